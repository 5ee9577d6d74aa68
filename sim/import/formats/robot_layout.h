#ifndef SINEW_SIM_IMPORT_FORMATS_ROBOT_LAYOUT_H_
#define SINEW_SIM_IMPORT_FORMATS_ROBOT_LAYOUT_H_

#include <vector>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "proto/sinew/v1/skeleton_map.pb.h"

namespace sinew::import {

// Layouts of robots' recordings: which column is which joint.
//
// Thread-safety: any thread. Blocking: KnownRobotLayouts reads files. Errors:
// below.

// Reads a v1::RobotLayout in text format. INVALID_ARGUMENT naming `source` and
// field, expected and found: syntax, a name other than [a-z0-9_]+, no joints,
// more than 500, one without a name or twice, a frame rate that none can be.
absl::StatusOr<v1::RobotLayout> ParseRobotLayout(absl::string_view text,
                                                 absl::string_view source);

// The layouts that come with Sinew (sim/import/maps): g1_23dof, g1_29dof,
// h1_2. NOT_FOUND: the program lies where its files do not (lists where was
// looked).
absl::StatusOr<std::vector<v1::RobotLayout>> KnownRobotLayouts();

}  // namespace sinew::import

#endif  // SINEW_SIM_IMPORT_FORMATS_ROBOT_LAYOUT_H_
