#include "sim/import/formats/bvh_motion.h"

#include <cstdint>
#include <numbers>
#include <utility>

#include "absl/strings/ascii.h"
#include "absl/strings/match.h"
#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/strip.h"
#include "common/status_macros.h"

namespace sinew::import {
namespace {

using Eigen::Quaterniond;
using Eigen::Vector3d;

constexpr double kDegree = std::numbers::pi / 180;

// Goes to the next line that is not empty.
bool NextFilled(TextLines& lines) {
  while (lines.Next()) {
    if (!lines.text().empty()) return true;
  }
  return false;
}

// The next line is "<key>: <value>"; its value.
absl::StatusOr<absl::string_view> ReadField(TextLines& lines,
                                            absl::string_view key,
                                            absl::string_view source) {
  const bool found = NextFilled(lines);
  if (!found || !absl::StartsWithIgnoreCase(lines.text(), key)) {
    return LineError(
        source, lines.number(),
        absl::StrCat("expected \"", key, ":\", found ",
                     found ? Quoted(lines.text()) : "the end of the file"));
  }
  absl::string_view value =
      absl::StripLeadingAsciiWhitespace(lines.text().substr(key.size()));
  absl::ConsumePrefix(&value, ":");
  return absl::StripLeadingAsciiWhitespace(value);
}

// The numbers of a line, one per channel, into `row`.
absl::Status ReadRow(const TextLines& lines, size_t frame,
                     absl::string_view source, std::vector<double>& row) {
  absl::string_view rest = lines.text();
  size_t count = 0;
  for (absl::string_view word = TakeWord(&rest); !word.empty();
       word = TakeWord(&rest), ++count) {
    if (count >= row.size()) continue;
    const absl::StatusOr<double> value = ParseNumber(word);
    if (!value.ok()) {
      return LineError(source, lines.number(),
                       absl::StrCat("frame ", frame, ": channel ", count, ": ",
                                    value.status().message()));
    }
    row[count] = *value;
  }
  if (count != row.size()) {
    return LineError(source, lines.number(),
                     absl::StrCat("frame ", frame, ": expected ", row.size(),
                                  " numbers (one per channel), found ", count));
  }
  return absl::OkStatus();
}

void AddPose(const BvhHierarchy& hierarchy, const std::vector<double>& row,
             BvhMotion& motion) {
  SourcePose pose;
  pose.rotation.reserve(hierarchy.joints.size());
  auto value = row.begin();
  for (size_t i = 0; i < hierarchy.joints.size(); ++i) {
    const BvhJoint& joint = hierarchy.joints[i];
    Vector3d position = joint.offset;
    Quaterniond rotation = Quaterniond::Identity();
    for (const BvhChannel& channel : joint.channels) {
      if (channel.is_position) {
        position[channel.axis] = *value++;
      } else {
        rotation = rotation * Eigen::AngleAxisd(*value++ * kDegree,
                                                Vector3d::Unit(channel.axis));
      }
    }
    if (i == 0) {
      pose.root_position = position;
    } else if (joint.has_position()) {
      motion.positions[i].push_back(position);
    }
    pose.rotation.push_back(rotation.normalized());
  }
  motion.poses.push_back(std::move(pose));
}

absl::Status CountError(absl::string_view source, int64_t line,
                        int64_t expected, absl::string_view found) {
  return LineError(source, line,
                   absl::StrCat("expected ", expected,
                                " frames as \"Frames\" says, "
                                "found ",
                                found));
}

}  // namespace

absl::StatusOr<BvhMotion> ReadBvhMotion(TextLines& lines,
                                        const BvhHierarchy& hierarchy,
                                        size_t max_rotations,
                                        absl::string_view source) {
  SINEW_ASSIGN_OR_RETURN(absl::string_view count_text,
                         ReadField(lines, "Frames", source));
  int64_t count = 0;
  if (!absl::SimpleAtoi(count_text, &count) || count < 1) {
    return LineError(source, lines.number(),
                     absl::StrCat("\"Frames\": expected a number of at least "
                                  "1, found ",
                                  Quoted(count_text)));
  }
  SINEW_ASSIGN_OR_RETURN(absl::string_view time_text,
                         ReadField(lines, "Frame Time", source));
  const absl::StatusOr<double> frame_time = ParseNumber(time_text);
  if (!frame_time.ok()) {
    return LineError(
        source, lines.number(),
        absl::StrCat("\"Frame Time\": ", frame_time.status().message()));
  }
  BvhMotion motion;
  motion.frame_time = *frame_time;
  motion.positions.resize(hierarchy.joints.size());
  std::vector<double> row(hierarchy.num_channels);
  while (NextFilled(lines)) {
    const size_t frame = motion.poses.size();
    if (static_cast<int64_t>(frame) == count) {
      return CountError(source, lines.number(), count, "more");
    }
    SINEW_RETURN_IF_ERROR(CheckRotations(hierarchy.joints.size(), frame + 1,
                                         max_rotations, source));
    SINEW_RETURN_IF_ERROR(ReadRow(lines, frame, source, row));
    AddPose(hierarchy, row, motion);
  }
  const auto found = static_cast<int64_t>(motion.poses.size());
  if (found != count) {
    return CountError(source, lines.number(), count, absl::StrCat(found));
  }
  return motion;
}

}  // namespace sinew::import
