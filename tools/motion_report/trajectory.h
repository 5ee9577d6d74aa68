#ifndef SINEW_TOOLS_MOTION_REPORT_TRAJECTORY_H_
#define SINEW_TOOLS_MOTION_REPORT_TRAJECTORY_H_

#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "common/policy/safetensors.h"
#include "sim/import/import_clip.h"

namespace sinew::motion_report {

// At most this much of a clip is put into a page.
inline constexpr double kShownSeconds = 10;
inline constexpr double kShownRate = 30;  // frames per second

// What a page plays of one clip. Numbers are packed as little-endian int16:
// positions in millimetres, quaternions (wxyz) in 1 / 32767.
struct Trajectory {
  double frames_per_second = 0;
  int frames = 0;
  int bodies = 0;
  std::string body_position;        // [frames, bodies, 3] base64
  std::string body_rotation;        // [frames, bodies, 4] base64
  std::vector<int> source_parents;  // [joints]; empty: no source skeleton
  std::string source_position;      // [frames, joints, 3] base64
  bool cut = false;                 // the clip is longer

  size_t bytes() const {
    return body_position.size() + body_rotation.size() + source_position.size();
  }
};

// `frames` as sim/motion/library.h lists them, at `rate` per second. The clip
// is cut where the root is more than 30 m from where it begins; positions of
// other bodies beyond 32.767 m are held there. INVALID_ARGUMENT: no frames, or
// tensors of another shape. Pure.
absl::StatusOr<Trajectory> MakeTrajectory(const TensorMap& frames, double rate,
                                          const import::SourcePreview& source);

}  // namespace sinew::motion_report

#endif  // SINEW_TOOLS_MOTION_REPORT_TRAJECTORY_H_
