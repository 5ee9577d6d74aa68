#ifndef SINEW_SIM_IMPORT_FORMATS_SOURCE_CLIP_H_
#define SINEW_SIM_IMPORT_FORMATS_SOURCE_CLIP_H_

#include <Eigen/Dense>
#include <Eigen/Geometry>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "proto/sinew/v1/motion.pb.h"

namespace sinew::import {

// A clip on the skeleton that it was recorded with, before any character: what
// every format reader produces and what retargeting starts from.
//
// World: metres, z up. In the rest pose every joint frame is aligned with the
// world, so offsets are world vectors and the identity rotation is the rest
// pose. Readers turn the file's axes into these by a cyclic change (y up:
// z' = y, x' = z, y' = x), so a rest pose that looks along the file's +z looks
// along +x; DeepMimic's, which looks along the file's +x, by a quarter turn
// about x (z' = y, x' = x, y' = -z). Which way it really looks, and in which
// pose it stands, is for retargeting to find.

// One ball joint (a hinge of the source is a ball that turns about one axis).
struct SourceJoint {
  std::string name;        // as in the file, e.g. "LeftUpLeg"
  int parent = -1;         // index of the parent, less than this one's; root -1
  Eigen::Vector3d offset;  // origin in the parent's frame, m; root: zero
  // The end of a limb (tip of a toe, top of the head): never turns by itself.
  bool is_end = false;
};

// What a user may say of a file; unset: read from it, or concluded.
struct ReadOptions {
  std::optional<double> metres_per_unit = {};
  std::optional<char> up_axis = {};  // 'x', 'y' or 'z'
  std::optional<double> frames_per_second = {};
  std::optional<std::string> quaternion_order = {};  // "wxyz" or "xyzw"
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
  // How the file was read; `map` unset.
  v1::ClipSource facts;
  // Things worth a look, one sentence each.
  std::vector<std::string> warnings;

  double duration() const { return poses.back().time; }
};

// A robot file's quaternion may be this far from unit length; readers normalise
// it.
inline constexpr double kRobotNormTolerance = 0.01;

// A clip in the coordinates of a robot: nothing to retarget but joint names.
struct RobotPose {
  double time = 0;                // s from the start
  Eigen::Vector3d root_position;  // world, m, z up
  Eigen::Quaterniond root_rotation;
  Eigen::VectorXd joints;  // rad, [joints]
};

struct RobotClip {
  std::string name;
  // In the order of RobotPose::joints; all different.
  std::vector<std::string> joints;
  // At least two, time strictly rising from 0.
  std::vector<RobotPose> poses;
  bool loops = false;
  v1::ClipSource facts;
  std::vector<std::string> warnings;

  double duration() const { return poses.back().time; }
};

// What a file holds.
using Source = std::variant<SourceClip, RobotClip>;

// Longest clip that any format may hold, seconds.
inline constexpr double kMaxClipSeconds = 4 * 3600;

// World rotations of all joints, parents first.
std::vector<Eigen::Quaterniond> WorldRotations(
    const SourceSkeleton& skeleton,
    const std::vector<Eigen::Quaterniond>& rotation);

// World positions of all joint origins.
std::vector<Eigen::Vector3d> WorldPositions(
    const SourceSkeleton& skeleton, const Eigen::Vector3d& root_position,
    const std::vector<Eigen::Quaterniond>& rotation);
std::vector<Eigen::Vector3d> WorldPositions(const SourceSkeleton& skeleton,
                                            const SourcePose& pose);

}  // namespace sinew::import

#endif  // SINEW_SIM_IMPORT_FORMATS_SOURCE_CLIP_H_
