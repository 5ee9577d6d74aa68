#ifndef SINEW_SIM_IMPORT_FORMATS_ASF_TEXT_H_
#define SINEW_SIM_IMPORT_FORMATS_ASF_TEXT_H_

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "sim/import/formats/asf_amc.h"

namespace sinew::import {

// An ASF file as it is written: bones and who is said to be whose child.

// Angles about three axes, the first one first, in the file's unit.
struct AsfAngles {
  double value[3] = {0, 0, 0};
  int axis[3] = {0, 1, 2};
};

struct AsfTextBone {
  std::string name;
  Eigen::Vector3d direction = Eigen::Vector3d::Zero();
  double length = -1;  // unset
  AsfAngles axis;
  std::vector<AsfChannel> channels;
};

// One child in the hierarchy.
struct AsfLink {
  int64_t line;
  std::string parent;
  std::string child;
};

struct AsfText {
  // [0] is the root, of length 0 and turned by its orientation; at least two,
  // with names and lengths.
  std::vector<AsfTextBone> bones;
  std::vector<AsfLink> links;
  Eigen::Vector3d root_position = Eigen::Vector3d::Zero();
  std::optional<double> length;
  bool angles_in_degrees = true;
  int64_t num_lines = 0;
};

// INVALID_ARGUMENT naming the line: a section, field or number that is none.
absl::StatusOr<AsfText> ReadAsfText(absl::string_view bytes,
                                    absl::string_view source);

}  // namespace sinew::import

#endif  // SINEW_SIM_IMPORT_FORMATS_ASF_TEXT_H_
