#include "sim/import/formats/file_frame.h"

#include <cmath>
#include <string>

#include "absl/strings/str_cat.h"
#include "sim/import/formats/body_size.h"

namespace sinew::import {
namespace {

using Eigen::Quaterniond;
using Eigen::Vector3d;

constexpr double kMinMetresPerUnit = 1e-6;
constexpr double kMaxMetresPerUnit = 1e3;
// How far rounding takes a rate away from a whole number.
constexpr double kRateRounding = 2e-4;

// Which axis of the file becomes the world's x, y and z.
struct Axes {
  int x, y, z;
};

Axes AxesOf(char up_axis) {
  if (up_axis == 'x') return {1, 2, 0};
  if (up_axis == 'y') return {2, 0, 1};
  return {0, 1, 2};
}

// A cyclic change turns nothing over, so vector parts of quaternions follow.
Vector3d Turned(const Axes& axes, const Vector3d& v) {
  return {v[axes.x], v[axes.y], v[axes.z]};
}

Quaterniond Turned(const Axes& axes, const Quaterniond& q) {
  const Vector3d vector = Turned(axes, Vector3d(q.vec()));
  return {q.w(), vector.x(), vector.y(), vector.z()};
}

double MetresPerUnit(const FileFrame& file, const ReadOptions& options,
                     SourceClip& clip) {
  if (options.metres_per_unit.has_value()) return *options.metres_per_unit;
  if (file.metres_per_unit.has_value()) return *file.metres_per_unit;
  clip.facts.add_concluded("metres_per_unit");
  const ConcludedUnit unit =
      ConcludeUnit(clip.skeleton, file.usual_metres_per_unit);
  if (!unit.is_usual) {
    clip.warnings.push_back(absl::StrCat(
        "no usual unit of length makes the skeleton as large as a person: one "
        "unit is taken for ",
        unit.metres_per_unit, " m"));
  }
  return unit.metres_per_unit;
}

char UpAxis(const FileFrame& file, const ReadOptions& options,
            SourceClip& clip) {
  if (options.up_axis.has_value()) return *options.up_axis;
  if (file.up_axis.has_value()) return *file.up_axis;
  clip.facts.add_concluded("up_axis");
  return ConcludeUpAxis(clip);
}

absl::Status CheckRange(const char* what, const std::optional<double>& value,
                        double low, double high) {
  if (!value.has_value() || (*value >= low && *value <= high)) {
    return absl::OkStatus();
  }
  return absl::InvalidArgumentError(
      absl::StrCat(what, ": expected a number from ", low, " to ", high,
                   ", found ", *value));
}

}  // namespace

absl::Status CheckReadOptions(const ReadOptions& options) {
  absl::Status status = CheckRange("metres per unit", options.metres_per_unit,
                                   kMinMetresPerUnit, kMaxMetresPerUnit);
  status.Update(CheckRange("frames per second", options.frames_per_second,
                           kMinFramesPerSecond, kMaxFramesPerSecond));
  if (!status.ok()) return status;
  const char up = options.up_axis.value_or('y');
  if (up != 'x' && up != 'y' && up != 'z') {
    return absl::InvalidArgumentError(absl::StrCat(
        "up axis: expected x, y or z, found \"", std::string(1, up), "\""));
  }
  const std::string order = options.quaternion_order.value_or("wxyz");
  if (order != "wxyz" && order != "xyzw") {
    return absl::InvalidArgumentError(absl::StrCat(
        "quaternion order: expected wxyz or xyzw, found \"", order, "\""));
  }
  return absl::OkStatus();
}

absl::Status CheckFixedFrame(const ReadOptions& options, double metres_per_unit,
                             char up_axis, absl::string_view format,
                             absl::string_view source) {
  const double unit = options.metres_per_unit.value_or(metres_per_unit);
  if (unit != metres_per_unit) {
    return absl::InvalidArgumentError(
        absl::StrCat(source, ": metres_per_unit: expected ", metres_per_unit,
                     ", as ", format, " always has it, found ", unit));
  }
  const char up = options.up_axis.value_or(up_axis);
  if (up == up_axis) return absl::OkStatus();
  return absl::InvalidArgumentError(absl::StrCat(
      source, ": up_axis: expected ", absl::string_view(&up_axis, 1), ", as ",
      format, " always has it, found ", absl::string_view(&up, 1)));
}

void MoveToWorld(const FileFrame& file, const ReadOptions& options,
                 SourceClip& clip) {
  const double scale = MetresPerUnit(file, options, clip);
  const char up_axis = UpAxis(file, options, clip);
  clip.facts.set_metres_per_unit(scale);
  clip.facts.set_up_axis(std::string(1, up_axis));
  const Axes axes = AxesOf(up_axis);
  for (SourceJoint& joint : clip.skeleton.joints) {
    joint.offset = scale * Turned(axes, joint.offset);
  }
  for (SourcePose& pose : clip.poses) {
    pose.root_position = scale * Turned(axes, pose.root_position);
    for (Quaterniond& rotation : pose.rotation) {
      rotation = Turned(axes, rotation);
    }
  }
}

absl::Status SetTimes(double frames_per_second, absl::string_view source,
                      SourceClip& clip) {
  if (clip.poses.size() == 1) {
    clip.poses.push_back(clip.poses[0]);
    clip.warnings.push_back("the file has a single pose: held for one frame");
  }
  for (size_t i = 0; i < clip.poses.size(); ++i) {
    clip.poses[i].time = static_cast<double>(i) / frames_per_second;
  }
  if (clip.duration() > kMaxClipSeconds) {
    return absl::InvalidArgumentError(
        absl::StrCat(source, ": expected a clip of at most ", kMaxClipSeconds,
                     " s, found ", clip.poses.size(), " frames at ",
                     frames_per_second, " a second, ", clip.duration(), " s"));
  }
  clip.facts.set_frames_per_second(frames_per_second);
  clip.facts.set_duration_s(clip.duration());
  return absl::OkStatus();
}

double RateOfFrameTime(double seconds) {
  const double rate = 1 / seconds;
  const double whole = std::round(rate);
  return std::abs(rate - whole) <= kRateRounding * rate ? whole : rate;
}

}  // namespace sinew::import
