#ifndef SINEW_DEPLOY_RUNTIME_POSE_H_
#define SINEW_DEPLOY_RUNTIME_POSE_H_

#include <mujoco/mujoco.h>

#include <Eigen/Geometry>
#include <vector>

#include "absl/status/status.h"
#include "absl/strings/string_view.h"
#include "deploy/runtime/sinew_runtime.h"
#include "sim/character/character.h"
#include "sim/motion/library.h"

namespace sinew::runtime {

// The caller's plain numbers; the C interface's struct.
using Pose = ::sinew_pose;

// What a pose must have beside joints, rotation and angular velocity.
struct PoseNeeds {
  int joints = 0;
  int feet = 0;
  bool root = false;  // position and linear velocity
  bool contact = false;
  bool torque = false;
};

// INVALID_ARGUMENT naming `what` ("state", "frames[1]"), the field and element:
// an array that is missing, a number that is no finite float32 (policies
// compute in these), a rotation that is not a unit quaternion within 1e-3.
// Allocates only then.
absl::Status CheckPose(const Pose& pose, const PoseNeeds& needs,
                       absl::string_view what);

// Numbers of a pose with a place of their own.
class PoseBuffer {
 public:
  explicit PoseBuffer(int joints);
  PoseBuffer(const PoseBuffer&) = delete;
  PoseBuffer& operator=(const PoseBuffer&) = delete;

  // From a simulation's qpos and qvel; from a library's row. No allocation.
  void Read(const character::Character& character, const mjData& data);
  void Read(const motion::FrameView& frame);

  // Turns about the vertical, then moves.
  void Move(const Eigen::Quaterniond& turn, const Eigen::Vector3d& offset);

  // Valid while the buffer lives; shows what was read last.
  const Pose& pose() const { return pose_; }

 private:
  double root_position_[3] = {0, 0, 0};
  double root_rotation_[4] = {1, 0, 0, 0};
  double root_linear_velocity_[3] = {0, 0, 0};
  double root_angular_velocity_[3] = {0, 0, 0};
  std::vector<double> joint_position_, joint_velocity_, torque_;
  Pose pose_{};
};

// Puts a checked pose into qpos and qvel; missing root position and velocity
// are zeros. No allocation.
void SetPose(const character::Character& character, const Pose& pose,
             mjData* data);

}  // namespace sinew::runtime

#endif  // SINEW_DEPLOY_RUNTIME_POSE_H_
