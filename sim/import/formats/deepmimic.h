#ifndef SINEW_SIM_IMPORT_FORMATS_DEEPMIMIC_H_
#define SINEW_SIM_IMPORT_FORMATS_DEEPMIMIC_H_

#include <cstdint>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "sim/import/formats/source_clip.h"

namespace sinew::import {

// The DeepMimic JSON format of the humanoid (facts published with DeepMimic,
// github.com/xbpeng/DeepMimic, data/characters/humanoid3d.txt):
//   {"Loop": "wrap" | "none", "Frames": [[44 numbers], ...]}
// A frame: seconds until the next frame (1), root position (3), root rotation
// (4), then parent-relative rotations: chest 4, neck 4, right hip 4, right
// knee 1, right ankle 4, right shoulder 4, right elbow 1, and the same five of
// the left. Quaternions wxyz; y up, x forward, z right; metres, radians. Other
// keys are ignored. "wrap": the last frame is the first one of the next cycle.

// Columns of a frame.
inline constexpr int kDeepMimicColumns = 44;
// A quaternion may be this far from unit length; it is normalised. Published
// clips are off by up to 0.42 (humanoid3d_kick).
inline constexpr double kDeepMimicNormTolerance = 0.5;
// Larger input is refused.
inline constexpr int64_t kDeepMimicMaxBytes = int64_t{256} << 20;

// Skeleton of the format, 15 joints with the end of each hand.
const SourceSkeleton& DeepMimicSkeleton();

// Reads a clip. Total: any bytes give a clip or INVALID_ARGUMENT that names
// `source`, the frame and column, what was expected and what was found
// (RESOURCE_EXHAUSTED: too large). Memory is bounded by a small multiple of
// the input. `name` becomes the clip's. Options: frames_per_second goes before
// the frames' own times; unit and up axis can only be what the format has.
absl::StatusOr<SourceClip> ParseDeepMimic(absl::string_view json,
                                          absl::string_view name,
                                          absl::string_view source,
                                          const ReadOptions& options);

}  // namespace sinew::import

#endif  // SINEW_SIM_IMPORT_FORMATS_DEEPMIMIC_H_
