#ifndef SINEW_SIM_IMPORT_FORMATS_BVH_HIERARCHY_H_
#define SINEW_SIM_IMPORT_FORMATS_BVH_HIERARCHY_H_

#include <Eigen/Core>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "sim/import/formats/text_lines.h"

namespace sinew::import {

// The first half of a BVH file, in the file's axes and units.

struct BvhChannel {
  bool is_position = false;  // else a rotation
  int axis = 0;              // 0, 1, 2: x, y, z
};

struct BvhJoint {
  std::string name;  // unique
  int parent = -1;   // less than the joint's own index
  bool is_end = false;
  bool has_offset = false;
  Eigen::Vector3d offset = Eigen::Vector3d::Zero();
  std::vector<BvhChannel> channels;

  bool has_position() const;
};

struct BvhHierarchy {
  std::vector<BvhJoint> joints;  // [0] is the root
  int num_channels = 0;          // of all joints; at least one
  std::vector<std::string> warnings;
};

// Reads up to and including the line "MOTION". INVALID_ARGUMENT naming the
// line: anything else than ParseBvh says, more than 2000 joints, joints nested
// deeper than 256.
absl::StatusOr<BvhHierarchy> ReadBvhHierarchy(TextLines& lines,
                                              absl::string_view source);

}  // namespace sinew::import

#endif  // SINEW_SIM_IMPORT_FORMATS_BVH_HIERARCHY_H_
