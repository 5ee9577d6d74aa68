#ifndef SINEW_SIM_IMPORT_SOURCE_CLIP_H_
#define SINEW_SIM_IMPORT_SOURCE_CLIP_H_

#include <Eigen/Geometry>
#include <string>
#include <vector>

namespace sinew::import {

// A clip on the skeleton that it was recorded with, before any character: what
// every format reader produces and what retargeting starts from.
//
// World: metres, z up; the rest pose faces +x, +y is left. In the rest pose
// every joint frame is aligned with the world, so offsets are world vectors and
// the identity rotation is the rest pose.

// One ball joint (a hinge of the source is a ball that turns about one axis).
struct SourceJoint {
  std::string name;        // e.g. "left_hip"
  int parent = -1;         // index of the parent, less than this one's; root -1
  Eigen::Vector3d offset;  // origin in the parent's frame, m; root: zero
};

struct SourceSkeleton {
  std::vector<SourceJoint> joints;  // joint 0 is the root

  // -1 if absent.
  int Find(const std::string& name) const;
};

// One key of a clip.
struct SourcePose {
  double time = 0;                // s from the start of the clip
  Eigen::Vector3d root_position;  // world, m
  // [joints] parent-relative rotations, unit; [0] is the root in the world.
  std::vector<Eigen::Quaterniond> rotation;
};

struct SourceClip {
  std::string name;
  SourceSkeleton skeleton;
  // At least two, time strictly rising from 0.
  std::vector<SourcePose> poses;
  // The clip repeats: its last pose is the first one, moved over the ground.
  bool loops = false;
  // Largest |norm - 1| of a quaternion in the file, before normalisation.
  double quaternion_drift = 0;

  double duration() const { return poses.back().time; }
};

// World rotations of all joints, parents first.
std::vector<Eigen::Quaterniond> WorldRotations(
    const SourceSkeleton& skeleton,
    const std::vector<Eigen::Quaterniond>& rotation);

// World positions of all joint origins.
std::vector<Eigen::Vector3d> WorldPositions(
    const SourceSkeleton& skeleton, const Eigen::Vector3d& root_position,
    const std::vector<Eigen::Quaterniond>& rotation);

}  // namespace sinew::import

#endif  // SINEW_SIM_IMPORT_SOURCE_CLIP_H_
