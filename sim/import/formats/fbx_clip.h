#ifndef SINEW_SIM_IMPORT_FORMATS_FBX_CLIP_H_
#define SINEW_SIM_IMPORT_FORMATS_FBX_CLIP_H_

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "sim/import/formats/source_clip.h"

namespace sinew::import {

// ParseFbx (fbx.h) without a process around it: what fbx_reader does. Bytes
// that the library fails on may crash the caller.
absl::StatusOr<SourceClip> ReadFbxHere(absl::string_view bytes,
                                       absl::string_view source,
                                       const ReadOptions& options);

}  // namespace sinew::import

#endif  // SINEW_SIM_IMPORT_FORMATS_FBX_CLIP_H_
