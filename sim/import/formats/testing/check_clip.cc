#include "sim/import/formats/testing/check_clip.h"

#include <cmath>
#include <set>
#include <string>

#include "common/check.h"

namespace sinew::import::testing {
namespace {

void CheckUnit(const Eigen::Quaterniond& rotation) {
  SINEW_CHECK(std::abs(rotation.norm() - 1) < 1e-6) << rotation.norm();
}

template <typename Clip>
void CheckTimes(const Clip& clip) {
  SINEW_CHECK(clip.poses.size() >= 2) << clip.poses.size() << " poses";
  SINEW_CHECK(clip.poses[0].time == 0) << clip.poses[0].time;
  for (size_t i = 1; i < clip.poses.size(); ++i) {
    SINEW_CHECK(clip.poses[i].time > clip.poses[i - 1].time) << "pose " << i;
  }
  SINEW_CHECK(clip.duration() <= kMaxClipSeconds) << clip.duration();
}

void CheckSkeleton(const SourceSkeleton& skeleton) {
  std::set<std::string> names;
  for (size_t i = 0; i < skeleton.joints.size(); ++i) {
    const SourceJoint& joint = skeleton.joints[i];
    SINEW_CHECK(names.insert(joint.name).second) << joint.name << " twice";
    SINEW_CHECK(joint.parent < static_cast<int>(i)) << joint.name;
    SINEW_CHECK((joint.parent < 0) == (i == 0)) << joint.name;
    SINEW_CHECK(joint.offset.allFinite()) << joint.name;
    SINEW_CHECK(i > 0 || joint.offset.isZero(0)) << "offset of the root";
  }
}

}  // namespace

void CheckClip(const SourceClip& clip) {
  CheckTimes(clip);
  CheckSkeleton(clip.skeleton);
  for (const SourcePose& pose : clip.poses) {
    SINEW_CHECK(pose.root_position.allFinite());
    SINEW_CHECK(pose.rotation.size() == clip.skeleton.joints.size());
    for (const Eigen::Quaterniond& rotation : pose.rotation) {
      CheckUnit(rotation);
    }
  }
}

void CheckClip(const RobotClip& clip) {
  CheckTimes(clip);
  const std::set<std::string> names(clip.joints.begin(), clip.joints.end());
  SINEW_CHECK(names.size() == clip.joints.size()) << "a joint twice";
  for (const RobotPose& pose : clip.poses) {
    SINEW_CHECK(pose.root_position.allFinite());
    SINEW_CHECK(pose.joints.allFinite());
    SINEW_CHECK(pose.joints.size() ==
                static_cast<Eigen::Index>(clip.joints.size()));
    CheckUnit(pose.root_rotation);
  }
}

}  // namespace sinew::import::testing
