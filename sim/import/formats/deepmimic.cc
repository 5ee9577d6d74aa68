#include "sim/import/formats/deepmimic.h"

#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/string_view.h"
#include "common/status_macros.h"
#include "sim/import/formats/deepmimic_json.h"
#include "sim/import/formats/file_frame.h"
#include "sim/import/formats/text_lines.h"

namespace sinew::import {
namespace {

using Eigen::Quaterniond;
using Eigen::Vector3d;

// Metres and radians beyond this are damage; squares and sums of less stay
// precise.
constexpr double kMaxNumber = 1e6;

// From y up, z right to z up, y left: a quarter turn about x, so it maps
// vectors and the vector parts of quaternions alike.
Vector3d ToZUp(const Vector3d& v) { return {v.x(), -v.z(), v.y()}; }

// Degrees of freedom that a frame has for a joint.
enum class Kind { kBall, kHinge, kFixed };

struct Column {
  const char* name;
  int parent;
  Kind kind;
  double offset[3];  // y up, as published
};

// Hinges turn about the source's z axis.
constexpr Column kJoints[] = {
    {"root", -1, Kind::kBall, {0, 0, 0}},
    {"chest", 0, Kind::kBall, {0, 0.236151, 0}},
    {"neck", 1, Kind::kBall, {0, 0.223894, 0}},
    {"right_hip", 0, Kind::kBall, {0, 0, 0.084887}},
    {"right_knee", 3, Kind::kHinge, {0, -0.421546, 0}},
    {"right_ankle", 4, Kind::kBall, {0, -0.409870, 0}},
    {"right_shoulder", 1, Kind::kBall, {-0.02405, 0.24350, 0.18311}},
    {"right_elbow", 6, Kind::kHinge, {0, -0.274788, 0}},
    {"right_wrist", 7, Kind::kFixed, {0, -0.258947, 0}},
    {"left_hip", 0, Kind::kBall, {0, 0, -0.084887}},
    {"left_knee", 9, Kind::kHinge, {0, -0.421546, 0}},
    {"left_ankle", 10, Kind::kBall, {0, -0.409870, 0}},
    {"left_shoulder", 1, Kind::kBall, {-0.02405, 0.24350, -0.18311}},
    {"left_elbow", 12, Kind::kHinge, {0, -0.274788, 0}},
    {"left_wrist", 13, Kind::kFixed, {0, -0.258947, 0}},
};

SourceSkeleton MakeSkeleton() {
  SourceSkeleton skeleton;
  for (const Column& column : kJoints) {
    const Vector3d offset(column.offset[0], column.offset[1], column.offset[2]);
    skeleton.joints.push_back({column.name, column.parent, ToZUp(offset)});
  }
  return skeleton;
}

absl::Status FrameError(absl::string_view source, size_t frame,
                        const std::string& what) {
  return absl::InvalidArgumentError(
      absl::StrCat(source, ": frame ", frame, ": ", what));
}

// The quaternion at columns `first` .. first + 3, normalised.
absl::StatusOr<Quaterniond> ReadQuaternion(const std::vector<double>& row,
                                           int first, const char* joint,
                                           size_t frame,
                                           absl::string_view source,
                                           double* drift) {
  const Vector3d vector =
      ToZUp(Vector3d(row[first + 1], row[first + 2], row[first + 3]));
  const double norm = std::hypot(row[first], vector.norm());
  if (!(std::abs(norm - 1) <= kDeepMimicNormTolerance)) {
    return FrameError(
        source, frame,
        absl::StrFormat("rotation of %s (columns %d to %d): expected a unit "
                        "quaternion (norm 1 +- %g), found norm %g",
                        joint, first, first + 3, kDeepMimicNormTolerance,
                        norm));
  }
  *drift = std::max(*drift, std::abs(norm - 1));
  return Quaterniond(row[first] / norm, vector.x() / norm, vector.y() / norm,
                     vector.z() / norm);
}

// `timed`: whether the row says how long it lasts.
absl::Status CheckRow(const std::vector<double>& row, size_t frame, bool timed,
                      bool is_last, absl::string_view source) {
  if (row.size() != kDeepMimicColumns) {
    return FrameError(source, frame,
                      absl::StrCat("expected ", kDeepMimicColumns,
                                   " columns, found ", row.size()));
  }
  if (timed && row[0] < (is_last ? 0 : 1 / kMaxFramesPerSecond)) {
    return FrameError(source, frame,
                      absl::StrCat("duration (column 0): expected at least ",
                                   is_last ? 0 : 1 / kMaxFramesPerSecond,
                                   " seconds, found ", row[0]));
  }
  for (size_t column = 1; column < row.size(); ++column) {
    if (std::abs(row[column]) <= kMaxNumber) continue;
    return FrameError(source, frame,
                      absl::StrFormat("column %d: expected a number within "
                                      "+-%g, found %g",
                                      column, kMaxNumber, row[column]));
  }
  return absl::OkStatus();
}

absl::StatusOr<SourcePose> ReadPose(const std::vector<double>& row,
                                    size_t frame, absl::string_view source,
                                    double* drift) {
  SourcePose pose;
  pose.root_position = ToZUp(Vector3d(row[1], row[2], row[3]));
  int column = 4;
  for (const Column& joint : kJoints) {
    switch (joint.kind) {
      case Kind::kBall: {
        SINEW_ASSIGN_OR_RETURN(
            Quaterniond rotation,
            ReadQuaternion(row, column, joint.name, frame, source, drift));
        pose.rotation.push_back(rotation);
        column += 4;
        break;
      }
      case Kind::kHinge:
        pose.rotation.emplace_back(
            Eigen::AngleAxisd(row[column], ToZUp(Vector3d::UnitZ())));
        column += 1;
        break;
      case Kind::kFixed:
        pose.rotation.push_back(Quaterniond::Identity());
        break;
    }
  }
  return pose;
}

}  // namespace

const SourceSkeleton& DeepMimicSkeleton() {
  static const SourceSkeleton& skeleton = *new SourceSkeleton(MakeSkeleton());
  return skeleton;
}

absl::StatusOr<SourceClip> ParseDeepMimic(absl::string_view json,
                                          absl::string_view name,
                                          absl::string_view source,
                                          const ReadOptions& options) {
  SINEW_RETURN_IF_ERROR(CheckReadOptions(options));
  SINEW_RETURN_IF_ERROR(CheckFixedFrame(options, /*metres_per_unit=*/1,
                                        /*up_axis=*/'y', "DeepMimic's format",
                                        source));
  SINEW_RETURN_IF_ERROR(CheckFileSize(json, kDeepMimicMaxBytes, source));
  SINEW_ASSIGN_OR_RETURN(DeepMimicFile file, ReadDeepMimicJson(json, source));
  if (file.frames.size() < 2) {
    return absl::InvalidArgumentError(
        absl::StrCat(source, ": \"Frames\": expected at least 2 frames, found ",
                     file.frames.size()));
  }
  SourceClip clip;
  clip.name = std::string(name);
  clip.skeleton = DeepMimicSkeleton();
  clip.loops = file.loops;
  double time = 0;
  for (size_t i = 0; i < file.frames.size(); ++i) {
    const std::vector<double>& row = file.frames[i];
    const bool is_last = i + 1 == file.frames.size();
    SINEW_RETURN_IF_ERROR(
        CheckRow(row, i, !options.frames_per_second, is_last, source));
    SINEW_ASSIGN_OR_RETURN(SourcePose pose,
                           ReadPose(row, i, source, &clip.quaternion_drift));
    pose.time = time;
    if (time > kMaxClipSeconds) {
      return FrameError(source, i,
                        absl::StrCat("expected at most ", kMaxClipSeconds,
                                     " seconds, found ", time));
    }
    clip.poses.push_back(std::move(pose));
    time = options.frames_per_second
               ? static_cast<double>(i + 1) / *options.frames_per_second
               : time + row[0];
  }
  clip.facts.set_format("deepmimic");
  clip.facts.set_frames_per_second(static_cast<double>(clip.poses.size() - 1) /
                                   clip.duration());
  clip.facts.set_duration_s(clip.duration());
  clip.facts.set_metres_per_unit(1);
  clip.facts.set_up_axis("y");
  return clip;
}

}  // namespace sinew::import
