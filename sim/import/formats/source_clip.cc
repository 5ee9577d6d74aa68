#include "sim/import/formats/source_clip.h"

namespace sinew::import {

int SourceSkeleton::Find(const std::string& name) const {
  for (int i = 0; i < static_cast<int>(joints.size()); ++i) {
    if (joints[i].name == name) return i;
  }
  return -1;
}

std::vector<Eigen::Quaterniond> WorldRotations(
    const SourceSkeleton& skeleton,
    const std::vector<Eigen::Quaterniond>& rotation) {
  std::vector<Eigen::Quaterniond> world(rotation);
  for (size_t i = 1; i < world.size(); ++i) {
    world[i] = world[skeleton.joints[i].parent] * rotation[i];
  }
  return world;
}

std::vector<Eigen::Vector3d> WorldPositions(
    const SourceSkeleton& skeleton, const Eigen::Vector3d& root_position,
    const std::vector<Eigen::Quaterniond>& rotation) {
  const std::vector<Eigen::Quaterniond> world =
      WorldRotations(skeleton, rotation);
  std::vector<Eigen::Vector3d> position(world.size(), root_position);
  for (size_t i = 1; i < world.size(); ++i) {
    const SourceJoint& joint = skeleton.joints[i];
    position[i] = position[joint.parent] + world[joint.parent] * joint.offset;
  }
  return position;
}

std::vector<Eigen::Vector3d> WorldPositions(const SourceSkeleton& skeleton,
                                            const SourcePose& pose) {
  return WorldPositions(skeleton, pose.root_position, pose.rotation);
}

}  // namespace sinew::import
