#ifndef SINEW_SIM_IMPORT_FORMATS_MJCF_JOINTS_H_
#define SINEW_SIM_IMPORT_FORMATS_MJCF_JOINTS_H_

#include <tinyxml2.h>

#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"

namespace sinew::import {

// The coordinates of a MuJoCo model file (MJCF), as far as keyframes need
// them.
struct MjcfJoints {
  bool has_free_joint = false;
  std::vector<std::string>
      hinges;  // in the order of qpos, after the free joint
  std::vector<std::string> mocap_bodies;

  bool empty() const { return !has_free_joint && hinges.empty(); }
};

// Reads the <worldbody> sections below `mujoco`, with the types of joints that
// default classes give. INVALID_ARGUMENT naming `source` and element, expected
// and found: joints other than one free joint, first, and hinges with names;
// elements that stand for bodies which are not here.
absl::StatusOr<MjcfJoints> ReadMjcfJoints(const tinyxml2::XMLElement& mujoco,
                                          absl::string_view source);

}  // namespace sinew::import

#endif  // SINEW_SIM_IMPORT_FORMATS_MJCF_JOINTS_H_
