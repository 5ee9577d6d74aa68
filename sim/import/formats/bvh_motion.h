#ifndef SINEW_SIM_IMPORT_FORMATS_BVH_MOTION_H_
#define SINEW_SIM_IMPORT_FORMATS_BVH_MOTION_H_

#include <Eigen/Core>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "sim/import/formats/bvh_hierarchy.h"
#include "sim/import/formats/source_clip.h"
#include "sim/import/formats/text_lines.h"

namespace sinew::import {

// The second half of a BVH file, in the file's axes and units.
struct BvhMotion {
  double frame_time = 0;  // s, as in the file
  // At least one; without times.
  std::vector<SourcePose> poses;
  // [joints][poses] place in the parent; empty for the root and for joints
  // without position channels.
  std::vector<std::vector<Eigen::Vector3d>> positions;
};

// Reads from the line after "MOTION" to the end. Errors as ParseBvh's.
// `max_rotations`: joints times frames, beyond it RESOURCE_EXHAUSTED.
absl::StatusOr<BvhMotion> ReadBvhMotion(TextLines& lines,
                                        const BvhHierarchy& hierarchy,
                                        size_t max_rotations,
                                        absl::string_view source);

}  // namespace sinew::import

#endif  // SINEW_SIM_IMPORT_FORMATS_BVH_MOTION_H_
