#ifndef SINEW_SIM_IMPORT_FORMATS_ROBOT_CSV_H_
#define SINEW_SIM_IMPORT_FORMATS_ROBOT_CSV_H_

#include <cstdint>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "proto/sinew/v1/skeleton_map.pb.h"
#include "sim/import/formats/source_clip.h"

namespace sinew::import {

// Recordings of a robot as text: a frame a line, numbers between commas,
// semicolons or white space: position of the root (m, z up), its rotation as
// four columns, joint angles (rad). An optional first line, which may start
// with #, names the columns.
//
// Joints: those that the first line names, if it names joints of one of the
// layouts ("left_knee", "left_knee_joint" and "left_knee_joint_dof" are the
// same), in any order; else those of the only layout that has as many.
//
// Rate: as given; else of the layout; else kDefaultRobotRate. A rate that was
// not given is "concluded" in the facts, and worth a warning.
//
// Quaternion order: as given; else as the first line names the columns (ending
// in w, x, y, z: "qw", "root_rot_w"); else facts.quaternion_order stays unset,
// and root_rotation holds the file's columns as w, x, y, z, until
// SettleQuaternionOrder (quaternion_order.h) says otherwise.

inline constexpr double kDefaultRobotRate = 30;
// Larger files are refused.
inline constexpr int64_t kRobotCsvMaxBytes = int64_t{256} << 20;

// Reads a clip. Total: any bytes give a clip or an error that names `source`,
// line and column, expected and found. INVALID_ARGUMENT: the bytes, or a number
// of columns that no layout or several have (the counts known are named);
// RESOURCE_EXHAUSTED: too large or longer than kMaxClipSeconds. Options:
// metres_per_unit is that of the root's position; up_axis must be z.
absl::StatusOr<RobotClip> ParseRobotCsv(
    absl::string_view bytes, absl::string_view name, absl::string_view source,
    const ReadOptions& options, const std::vector<v1::RobotLayout>& layouts);

}  // namespace sinew::import

#endif  // SINEW_SIM_IMPORT_FORMATS_ROBOT_CSV_H_
