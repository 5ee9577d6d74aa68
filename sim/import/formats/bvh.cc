#include "sim/import/formats/bvh.h"

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "common/status_macros.h"
#include "sim/import/formats/bvh_hierarchy.h"
#include "sim/import/formats/bvh_motion.h"
#include "sim/import/formats/file_frame.h"
#include "sim/import/formats/text_lines.h"

namespace sinew::import {
namespace {

using Eigen::Vector3d;

// A joint that its position channels move further than this is worth a word, m.
constexpr double kStretch = 0.01;

// Median of each coordinate.
Vector3d Median(std::vector<Vector3d> points) {
  Vector3d median;
  const auto middle = points.begin() + (points.size() - 1) / 2;
  for (int axis = 0; axis < 3; ++axis) {
    std::nth_element(points.begin(), middle, points.end(),
                     [axis](const Vector3d& a, const Vector3d& b) {
                       return a[axis] < b[axis];
                     });
    median[axis] = (*middle)[axis];
  }
  return median;
}

SourceSkeleton MakeSkeleton(const BvhHierarchy& hierarchy,
                            const BvhMotion& motion) {
  SourceSkeleton skeleton;
  for (size_t i = 0; i < hierarchy.joints.size(); ++i) {
    const BvhJoint& joint = hierarchy.joints[i];
    Vector3d offset = i == 0 ? Vector3d(0, 0, 0) : joint.offset;
    if (!motion.positions[i].empty()) offset = Median(motion.positions[i]);
    skeleton.joints.push_back({joint.name, joint.parent, offset, joint.is_end});
  }
  return skeleton;
}

// `skeleton` is in the file's units.
void WarnOfStretching(const SourceSkeleton& skeleton, const BvhMotion& motion,
                      double metres_per_unit,
                      std::vector<std::string>& warnings) {
  int count = 0;
  size_t worst = 0;
  double largest = 0;
  for (size_t i = 0; i < skeleton.joints.size(); ++i) {
    double stretch = 0;
    for (const Vector3d& position : motion.positions[i]) {
      stretch =
          std::max(stretch, metres_per_unit *
                                (position - skeleton.joints[i].offset).norm());
    }
    if (stretch <= kStretch) continue;
    ++count;
    if (stretch > largest) {
      largest = stretch;
      worst = i;
    }
  }
  if (count == 0) return;
  warnings.push_back(absl::StrFormat(
      "%d joints are moved within their parents by position channels (%s by up "
      "to %.1f cm): their median places are taken",
      count, Quoted(skeleton.joints[worst].name), largest * 100));
}

absl::StatusOr<double> Rate(const BvhMotion& motion, const ReadOptions& options,
                            absl::string_view source) {
  if (options.frames_per_second.has_value()) return *options.frames_per_second;
  const double rate =
      motion.frame_time > 0 ? RateOfFrameTime(motion.frame_time) : 0;
  if (!(rate >= kMinFramesPerSecond && rate <= kMaxFramesPerSecond)) {
    return absl::InvalidArgumentError(absl::StrCat(
        source, ": \"Frame Time\": expected ", 1 / kMaxFramesPerSecond, " to ",
        1 / kMinFramesPerSecond, " seconds, found ", motion.frame_time));
  }
  return rate;
}

}  // namespace

absl::StatusOr<SourceClip> ParseBvh(absl::string_view bytes,
                                    absl::string_view name,
                                    absl::string_view source,
                                    const ReadOptions& options) {
  SINEW_RETURN_IF_ERROR(CheckReadOptions(options));
  SINEW_RETURN_IF_ERROR(CheckFileSize(bytes, kBvhMaxBytes, source));
  TextLines lines(bytes);
  SINEW_ASSIGN_OR_RETURN(BvhHierarchy hierarchy,
                         ReadBvhHierarchy(lines, source));
  SINEW_ASSIGN_OR_RETURN(
      BvhMotion motion,
      ReadBvhMotion(lines, hierarchy, MaxRotations(bytes.size()), source));
  SINEW_ASSIGN_OR_RETURN(const double rate, Rate(motion, options, source));
  SourceClip clip;
  clip.name = std::string(name);
  clip.facts.set_format("bvh");
  clip.warnings = std::move(hierarchy.warnings);
  clip.poses = std::move(motion.poses);
  const SourceSkeleton skeleton = MakeSkeleton(hierarchy, motion);
  clip.skeleton = skeleton;
  MoveToWorld(FileFrame(), options, clip);
  WarnOfStretching(skeleton, motion, clip.facts.metres_per_unit(),
                   clip.warnings);
  SINEW_RETURN_IF_ERROR(SetTimes(rate, source, clip));
  return clip;
}

}  // namespace sinew::import
