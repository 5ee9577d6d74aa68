#include "sim/import/formats/body_size.h"

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <string>
#include <vector>

#include "absl/strings/ascii.h"
#include "absl/strings/match.h"
#include "absl/strings/string_view.h"

namespace sinew::import {
namespace {

using Eigen::Vector3d;

// Root to the toes along the bones, and root to the farthest end (a hand), of a
// grown person, m.
constexpr double kLegLength = 1.1;
constexpr double kLongestChain = 1.2;
// Sizes that pass for a person's, by the above. Children are small; nobody is
// much larger.
constexpr double kSmallest = 0.6;
constexpr double kLargest = 1.3;
// A smaller skeleton has no size, units.
constexpr double kNoSize = 1e-6;

constexpr double kUnits[] = {1, 0.1, 0.01, 0.001, 0.0254, 0.0254 / 0.45};

// Poses that are looked at.
constexpr size_t kSamples = 32;

std::vector<int> JointsLike(const SourceSkeleton& skeleton,
                            std::initializer_list<const char*> words) {
  std::vector<int> found;
  for (int i = 1; i < static_cast<int>(skeleton.joints.size()); ++i) {
    if (skeleton.joints[i].is_end) continue;
    const std::string name = absl::AsciiStrToLower(skeleton.joints[i].name);
    for (const char* word : words) {
      if (!absl::StrContains(name, word)) continue;
      found.push_back(i);
      break;
    }
  }
  return found;
}

std::vector<int> Feet(const SourceSkeleton& skeleton) {
  return JointsLike(skeleton, {"foot", "ankle", "toe"});
}

// Size over that of a person, 1/m.
double RelativeSize(const SourceSkeleton& skeleton) {
  std::vector<double> chain(skeleton.joints.size(), 0.0);
  double longest = 0;
  for (size_t i = 1; i < chain.size(); ++i) {
    const SourceJoint& joint = skeleton.joints[i];
    chain[i] = chain[joint.parent] + joint.offset.norm();
    longest = std::max(longest, chain[i]);
  }
  double leg = 0;
  for (const int foot : Feet(skeleton)) leg = std::max(leg, chain[foot]);
  return leg > kNoSize ? leg / kLegLength : longest / kLongestChain;
}

bool IsOfAPerson(double relative_size) {
  return relative_size >= kSmallest && relative_size <= kLargest;
}

// Unit vector from the root to the mean of some joints; zero without any.
Vector3d Towards(const std::vector<int>& joints,
                 const std::vector<Vector3d>& position) {
  Vector3d sum = Vector3d::Zero();
  for (const int joint : joints) sum += position[joint] - position[0];
  return sum.norm() > kNoSize ? sum.normalized() : Vector3d::Zero();
}

// Axis (1 or 2) that a standing rest pose has upwards, 0 if it does not stand.
int UpOfRestPose(const SourceSkeleton& skeleton, const std::vector<int>& feet,
                 const std::vector<int>& heads) {
  const std::vector<Eigen::Quaterniond> rest(skeleton.joints.size(),
                                             Eigen::Quaterniond::Identity());
  const std::vector<Vector3d> position =
      WorldPositions(skeleton, Vector3d::Zero(), rest);
  const Vector3d down = Towards(feet, position);
  const Vector3d up = Towards(heads, position);
  for (const int axis : {1, 2}) {
    if (down[axis] < -0.8 && (heads.empty() || up[axis] > 0.5)) return axis;
  }
  return 0;
}

// The same of the mean pose.
int UpOfPoses(const SourceClip& clip, const std::vector<int>& feet) {
  const size_t step = std::max<size_t>(1, clip.poses.size() / kSamples);
  Vector3d down = Vector3d::Zero();
  int count = 0;
  for (size_t i = 0; i < clip.poses.size(); i += step, ++count) {
    const SourcePose& pose = clip.poses[i];
    down += Towards(
        feet, WorldPositions(clip.skeleton, Vector3d::Zero(), pose.rotation));
  }
  const int axis = down.y() <= down.z() ? 1 : 2;
  return down[axis] < -0.5 * count ? axis : 0;
}

// The axis along which the root has the steadier height; y in doubt.
int UpOfRoot(const SourceClip& clip) {
  Vector3d sum = Vector3d::Zero();
  Vector3d low = clip.poses[0].root_position;
  Vector3d high = low;
  for (const SourcePose& pose : clip.poses) {
    sum += pose.root_position;
    low = low.cwiseMin(pose.root_position);
    high = high.cwiseMax(pose.root_position);
  }
  const Vector3d mean = sum / static_cast<double>(clip.poses.size());
  const Vector3d spread = high - low;
  const bool is_z = mean.z() > 0 && mean.z() > 2 * mean.y() &&
                    spread.z() <= std::max(spread.y(), mean.z());
  return is_z ? 2 : 1;
}

}  // namespace

ConcludedUnit ConcludeUnit(const SourceSkeleton& skeleton,
                           std::optional<double> usual) {
  const double size = RelativeSize(skeleton);
  if (!(size > kNoSize)) return {usual.value_or(1), /*is_usual=*/false};
  if (usual.has_value() && IsOfAPerson(size * *usual)) return {*usual, true};
  double best = kUnits[0];
  for (const double unit : kUnits) {
    if (std::abs(std::log(size * unit)) < std::abs(std::log(size * best))) {
      best = unit;
    }
  }
  if (IsOfAPerson(size * best)) return {best, true};
  return {1 / size, /*is_usual=*/false};
}

char ConcludeUpAxis(const SourceClip& clip) {
  const std::vector<int> feet = Feet(clip.skeleton);
  int axis = 0;
  if (!feet.empty()) {
    axis = UpOfRestPose(clip.skeleton, feet,
                        JointsLike(clip.skeleton, {"head", "neck"}));
    if (axis == 0) axis = UpOfPoses(clip, feet);
  }
  if (axis == 0) axis = UpOfRoot(clip);
  return axis == 2 ? 'z' : 'y';
}

}  // namespace sinew::import
