#include "sim/import/formats/robot_csv.h"

#include <cmath>
#include <map>
#include <set>
#include <string>
#include <utility>

#include "absl/status/status.h"
#include "absl/strings/ascii.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_join.h"
#include "absl/strings/strip.h"
#include "common/status_macros.h"
#include "sim/import/formats/file_frame.h"
#include "sim/import/formats/number_table.h"
#include "sim/import/formats/text_lines.h"

namespace sinew::import {
namespace {

using Eigen::Quaterniond;
using Eigen::Vector3d;

// Columns before those of the joints.
constexpr int kRootColumns = 7;
constexpr int kQuaternion = 3;
// Beyond them numbers cannot be what they should.
constexpr double kMaxPosition = 1e6;  // m
constexpr double kMaxAngle = 1000;    // rad

// A joint's or column's name without what dialects add to it.
std::string Stem(absl::string_view name) {
  std::string lower = absl::AsciiStrToLower(name);
  absl::string_view stem = lower;
  for (const char* suffix : {"_pos", "_rad", "_dof", "_joint"}) {
    absl::ConsumeSuffix(&stem, suffix);
  }
  return std::string(stem);
}

// Which columns are what.
struct Columns {
  std::vector<std::string> joints;  // in the order of the columns
  std::string map;
  double layout_rate = 0;        // 0: unknown
  std::string quaternion_order;  // empty: unknown
};

absl::Status ColumnsError(absl::string_view source,
                          const std::vector<v1::RobotLayout>& layouts,
                          absl::string_view found) {
  return absl::InvalidArgumentError(absl::StrCat(
      source, ": expected ", kRootColumns, " columns of the root and those of ",
      "one layout (",
      absl::StrJoin(layouts, ", ",
                    [](std::string* out, const v1::RobotLayout& layout) {
                      absl::StrAppend(out, layout.name(), ": ",
                                      layout.joints_size(), " joints");
                    }),
      "), found ", found));
}

absl::StatusOr<Columns> ColumnsByCount(
    int count, absl::string_view source,
    const std::vector<v1::RobotLayout>& layouts) {
  const v1::RobotLayout* match = nullptr;
  for (const v1::RobotLayout& layout : layouts) {
    if (layout.joints_size() != count - kRootColumns) continue;
    if (match != nullptr) {
      return ColumnsError(source, layouts,
                          absl::StrCat(count, " columns, as of ", match->name(),
                                       " and ", layout.name()));
    }
    match = &layout;
  }
  if (match == nullptr) {
    return ColumnsError(source, layouts, absl::StrCat(count, " columns"));
  }
  return Columns{.joints = {match->joints().begin(), match->joints().end()},
                 .map = match->name(),
                 .layout_rate = match->frames_per_second(),
                 .quaternion_order = ""};
}

// Columns whose names are joints of the smallest layout that has them all.
// Without joints in the result: no name is a joint's.
absl::StatusOr<Columns> ColumnsByName(
    const std::vector<std::string>& names, absl::string_view source,
    const std::vector<v1::RobotLayout>& layouts) {
  Columns columns;
  int smallest = 0;
  std::string unknown;
  for (const v1::RobotLayout& layout : layouts) {
    std::map<std::string, std::string> joints;  // by stem
    for (const std::string& joint : layout.joints()) {
      joints[Stem(joint)] = joint;
    }
    Columns found;
    std::string missing;
    for (size_t i = kRootColumns; i < names.size(); ++i) {
      const auto joint = joints.find(Stem(names[i]));
      if (joint != joints.end()) found.joints.push_back(joint->second);
      if (joint == joints.end() && missing.empty()) missing = names[i];
    }
    if (missing.empty() && !found.joints.empty()) {
      if (columns.map.empty() || layout.joints_size() < smallest) {
        smallest = layout.joints_size();
        found.map = layout.name();
        found.layout_rate = layout.frames_per_second();
        columns = std::move(found);
      }
    } else if (!found.joints.empty()) {
      unknown = missing;
    }
  }
  if (columns.map.empty() && !unknown.empty()) {
    return ColumnsError(source, layouts,
                        absl::StrCat("a column ", Quoted(unknown)));
  }
  const std::set<std::string> once(columns.joints.begin(),
                                   columns.joints.end());
  if (once.size() != columns.joints.size()) {
    return ColumnsError(source, layouts, "a joint twice");
  }
  return columns;
}

// The order that the names of four columns end in; empty: none.
std::string NamedOrder(const std::vector<std::string>& names) {
  std::string order;
  for (int i = kQuaternion; i < kRootColumns; ++i) {
    if (names[i].empty()) return "";
    order.push_back(absl::ascii_tolower(names[i].back()));
  }
  return order == "wxyz" || order == "xyzw" ? order : "";
}

absl::StatusOr<Columns> FindColumns(const NumberTable& table,
                                    absl::string_view source,
                                    const std::vector<v1::RobotLayout>& layouts,
                                    RobotClip* clip) {
  const int count = static_cast<int>(table.rows[0].size());
  if (count <= kRootColumns || table.names.empty()) {
    return ColumnsByCount(count, source, layouts);
  }
  SINEW_ASSIGN_OR_RETURN(Columns columns,
                         ColumnsByName(table.names, source, layouts));
  if (columns.joints.empty()) {
    SINEW_ASSIGN_OR_RETURN(columns, ColumnsByCount(count, source, layouts));
    clip->warnings.push_back(
        absl::StrCat("the first line names no joint that is known; the ",
                     "columns are taken in the order of ", columns.map));
  }
  columns.quaternion_order = NamedOrder(table.names);
  return columns;
}

// The root's rotation, from columns in a known order or taken as wxyz.
absl::StatusOr<Quaterniond> ReadQuaternion(const std::vector<double>& row,
                                           bool is_xyzw, int line,
                                           absl::string_view source) {
  const double* q = &row[kQuaternion];
  const Quaterniond rotation = is_xyzw ? Quaterniond(q[3], q[0], q[1], q[2])
                                       : Quaterniond(q[0], q[1], q[2], q[3]);
  const double norm = rotation.norm();
  if (!(std::abs(norm - 1) <= kRobotNormTolerance)) {
    return absl::InvalidArgumentError(absl::StrFormat(
        "%s: line %d, columns %d to %d: expected a unit quaternion (norm 1 +- "
        "%g), found norm %g",
        source, line, kQuaternion + 1, kRootColumns, kRobotNormTolerance,
        norm));
  }
  return rotation.normalized();
}

absl::Status CheckRange(const std::vector<double>& row, int line,
                        absl::string_view source) {
  for (size_t i = 0; i < row.size(); ++i) {
    const bool is_position = i < kQuaternion;
    const double limit = is_position ? kMaxPosition : kMaxAngle;
    if (std::abs(row[i]) <= limit) continue;
    return absl::InvalidArgumentError(absl::StrFormat(
        "%s: line %d, column %d: expected %s within +-%g, found %g", source,
        line, i + 1, is_position ? "m" : "rad", limit, row[i]));
  }
  return absl::OkStatus();
}

// The rate, and where it comes from in facts and warnings.
double ChooseRate(const Columns& columns, const ReadOptions& options,
                  RobotClip* clip) {
  if (options.frames_per_second.has_value()) return *options.frames_per_second;
  const bool by_layout = columns.layout_rate > 0;
  const double rate = by_layout ? columns.layout_rate : kDefaultRobotRate;
  clip->facts.add_concluded("frames_per_second");
  clip->warnings.push_back(absl::StrFormat(
      "the file says no frame rate; read at %g frames per second, %s", rate,
      by_layout ? absl::StrCat("as ", columns.map, " says") : "the default"));
  return rate;
}

absl::Status ReadPoses(const NumberTable& table, absl::string_view source,
                       double rate, RobotClip* clip) {
  for (size_t i = 0; i < table.rows.size(); ++i) {
    const std::vector<double>& row = table.rows[i];
    SINEW_RETURN_IF_ERROR(CheckRange(row, table.lines[i], source));
    RobotPose pose;
    pose.time = static_cast<double>(i) / rate;
    pose.root_position =
        clip->facts.metres_per_unit() * Vector3d(row[0], row[1], row[2]);
    SINEW_ASSIGN_OR_RETURN(
        pose.root_rotation,
        ReadQuaternion(row, clip->facts.quaternion_order() == "xyzw",
                       table.lines[i], source));
    pose.joints = Eigen::Map<const Eigen::VectorXd>(row.data() + kRootColumns,
                                                    row.size() - kRootColumns);
    clip->poses.push_back(std::move(pose));
  }
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<RobotClip> ParseRobotCsv(
    absl::string_view bytes, absl::string_view name, absl::string_view source,
    const ReadOptions& options, const std::vector<v1::RobotLayout>& layouts) {
  SINEW_RETURN_IF_ERROR(CheckReadOptions(options));
  SINEW_RETURN_IF_ERROR(CheckFileSize(bytes, kRobotCsvMaxBytes, source));
  if (options.up_axis.value_or('z') != 'z') {
    return absl::InvalidArgumentError(
        absl::StrCat(source, ": up_axis: expected z for a robot, found ",
                     std::string(1, *options.up_axis)));
  }
  SINEW_ASSIGN_OR_RETURN(const NumberTable table,
                         ParseNumberTable(bytes, source));
  RobotClip clip;
  clip.name = std::string(name);
  SINEW_ASSIGN_OR_RETURN(Columns columns,
                         FindColumns(table, source, layouts, &clip));
  if (table.rows.size() < 2) {
    return absl::InvalidArgumentError(absl::StrCat(
        source, ": expected at least 2 frames, found ", table.rows.size()));
  }
  const double rate = ChooseRate(columns, options, &clip);
  if (const double seconds = (table.rows.size() - 1) / rate;
      seconds > kMaxClipSeconds) {
    return absl::ResourceExhaustedError(
        absl::StrCat(source, ": expected at most ", kMaxClipSeconds,
                     " seconds, found ", seconds));
  }
  clip.joints = std::move(columns.joints);
  clip.facts.set_format("robot_csv");
  clip.facts.set_map(columns.map);
  clip.facts.set_frames_per_second(rate);
  clip.facts.set_metres_per_unit(options.metres_per_unit.value_or(1));
  clip.facts.set_up_axis("z");
  clip.facts.set_quaternion_order(
      options.quaternion_order.value_or(columns.quaternion_order));
  SINEW_RETURN_IF_ERROR(ReadPoses(table, source, rate, &clip));
  clip.facts.set_duration_s(clip.duration());
  return clip;
}

}  // namespace sinew::import
