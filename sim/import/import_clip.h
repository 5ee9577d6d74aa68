#ifndef SINEW_SIM_IMPORT_IMPORT_CLIP_H_
#define SINEW_SIM_IMPORT_IMPORT_CLIP_H_

#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "common/policy/safetensors.h"
#include "common/stop.h"
#include "proto/sinew/v1/motion.pb.h"
#include "proto/sinew/v1/skeleton_map.pb.h"
#include "sim/import/blend_clips.h"
#include "sim/import/edit.h"
#include "sim/import/formats/source_clip.h"
#include "sim/import/retarget/import_model.h"

namespace sinew::import {

// What the source's skeleton did, for pictures.
struct SourcePreview {
  double frames_per_second = 0;
  std::vector<int> parents;  // [joints], -1: root; empty: nothing to show
  // [frames, joints, 3] world, m, where the character's motion is.
  std::vector<float> positions;

  int joints() const { return static_cast<int>(parents.size()); }
  int frames() const {
    return parents.empty()
               ? 0
               : static_cast<int>(positions.size()) / (3 * joints());
  }
};

// At most this many frames per second and seconds of a clip are kept to show.
inline constexpr double kPreviewRate = 30;
inline constexpr double kPreviewSeconds = 20;

struct ClipOptions {
  // Frames per second of the library, > 0 and at most 1000.
  double rate = 30;
  // Roles of the source's joints; null: found or drafted.
  const v1::SkeletonMap* map = nullptr;
  // What to do with the clip once it is on the character.
  EditOptions edits = {};
  // Of the character; must be set if there are edits.
  const MotionMirror* mirror = nullptr;
  StopToken stop = {};
};

// A clip on a character, ready for a library.
struct ImportedClip {
  TensorMap frames;
  // Complete but for what depends on the file and the library: first_frame,
  // source_file, source_sha256, provenance, licence, trial.
  v1::ClipInfo info;
  SourcePreview preview;
  double duration_s = 0;  // of the motion, edits applied
  // Speed against the source, from rounding to whole frames.
  double retiming = 1;
  // Frames that the floor carries, share of all.
  double supported_share = 0;
  // Things worth a look, one sentence each.
  std::vector<std::string> warnings;
};

// Plays a clip on a character and computes what a library holds of it. Pure.
// Errors: INVALID_ARGUMENT naming the clip: options out of range, longer than
// kMaxClipSeconds, or it does not fit the character.
absl::StatusOr<ImportedClip> ImportClip(const ImportModel& model,
                                        const Source& source,
                                        const ClipOptions& options);

// The same for two clips that are joined over a gap into one (blend_clips.h);
// options.edits are of the whole. The info's `blend` says what follows the
// first, but for what depends on the file, and how long the gap is.
absl::StatusOr<ImportedClip> ImportBlend(const ImportModel& model,
                                         const Source& first,
                                         const Source& second,
                                         const BlendOptions& blend,
                                         const ClipOptions& options);

}  // namespace sinew::import

#endif  // SINEW_SIM_IMPORT_IMPORT_CLIP_H_
