#include "sim/import/formats/first_frame.h"

#include <algorithm>
#include <numbers>
#include <vector>

#include "common/check.h"

namespace sinew::import {
namespace {

using Eigen::Quaterniond;

constexpr double kDegree = std::numbers::pi / 180;
// Steps that the first one is held against: the median, since recordings have
// jumps of their own.
constexpr size_t kSteps = 10;

// Joints that can turn by themselves and are not the root.
bool Counts(const SourceJoint& joint) {
  return joint.parent >= 0 && !joint.is_end;
}

// Mean angle over joints between two poses, rad.
double Step(const SourceSkeleton& skeleton, const SourcePose& a,
            const SourcePose& b) {
  double sum = 0;
  int count = 0;
  for (size_t i = 0; i < skeleton.joints.size(); ++i) {
    if (!Counts(skeleton.joints[i])) continue;
    sum += a.rotation[i].angularDistance(b.rotation[i]);
    ++count;
  }
  return count > 0 ? sum / count : 0;
}

bool MostJointsAreUnturned(const SourceSkeleton& skeleton,
                           const SourcePose& pose) {
  int unturned = 0;
  int count = 0;
  for (size_t i = 0; i < skeleton.joints.size(); ++i) {
    if (!Counts(skeleton.joints[i])) continue;
    ++count;
    const double angle =
        pose.rotation[i].angularDistance(Quaterniond::Identity());
    if (angle < kDegree) ++unturned;
  }
  return 2 * unturned >= count;
}

}  // namespace

bool FirstFrameIsRest(const SourceClip& clip) {
  if (clip.poses.size() < 4) return false;
  if (!MostJointsAreUnturned(clip.skeleton, clip.poses[0])) return false;
  const double jump = Step(clip.skeleton, clip.poses[0], clip.poses[1]);
  std::vector<double> steps;
  for (size_t i = 1; i < std::min(kSteps, clip.poses.size() - 1); ++i) {
    steps.push_back(Step(clip.skeleton, clip.poses[i], clip.poses[i + 1]));
  }
  const auto median = steps.begin() + steps.size() / 2;
  std::nth_element(steps.begin(), median, steps.end());
  return jump > 5 * kDegree && jump > 5 * *median;
}

void DropFirstPose(SourceClip& clip) {
  SINEW_CHECK(clip.poses.size() >= 3) << clip.poses.size() << " poses";
  clip.poses.erase(clip.poses.begin());
  const double start = clip.poses[0].time;
  for (SourcePose& pose : clip.poses) pose.time -= start;
  clip.facts.set_duration_s(clip.duration());
}

}  // namespace sinew::import
