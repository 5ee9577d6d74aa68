#ifndef SINEW_SIM_IMPORT_FORMATS_FBX_H_
#define SINEW_SIM_IMPORT_FORMATS_FBX_H_

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "sim/import/formats/fbx_limits.h"
#include "sim/import/formats/source_clip.h"

namespace sinew::import {

// The animation of a skeleton in an FBX file, binary or text, as Mixamo,
// MotionBuilder, Maya and Blender write it. The Open Asset Import Library reads
// the file; it is not made for hostile bytes, so it does so in a process of its
// own (fbx_reader) with bounded memory and time. Whatever becomes of that
// process, here it is a clip or an error.
//
// Skeleton: the nodes that move or that a mesh is bound to, and the nodes below
// them; others of the file (meshes, lights, cameras) are left out. Rest pose:
// the one that a mesh was bound in, where there is a mesh; else that of the
// nodes without animation. Positions and turns are taken in the world, so that
// pre- and post-rotations, pivots and scales need no care later. A joint that
// moves along its parent is read as fixed, with a warning if that is much.
//
// Of several animations the one with the most moving joints, and of these the
// longest, is read. Unit and up axis are the file's; the rate is the file's
// unless its keys are denser, and then theirs.

// Reads a clip. Total: any bytes give a clip or an error that names `source`,
// expected and found. INVALID_ARGUMENT: not FBX, what the library says of it,
// that it crashed on it, no moving skeleton, numbers that are not finite;
// RESOURCE_EXHAUSTED: too large, too long, or more memory or time than
// fbx_limits.h allows; NOT_FOUND: the program fbx_reader is not where this
// one's files are.
//
// Thread-safety: any thread. Blocking: starts a process and waits for it, at
// most kFbxPatience.
absl::StatusOr<SourceClip> ParseFbx(absl::string_view bytes,
                                    absl::string_view name,
                                    absl::string_view source,
                                    const ReadOptions& options);

}  // namespace sinew::import

#endif  // SINEW_SIM_IMPORT_FORMATS_FBX_H_
