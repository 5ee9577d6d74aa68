#include "deploy/runtime/pose.h"

#include <algorithm>
#include <cmath>

#include "absl/strings/str_cat.h"
#include "common/status_macros.h"
#include "sim/motion/rotation.h"

namespace sinew::runtime {
namespace {

constexpr double kNormTolerance = 1e-3;

absl::Status CheckArray(const double* values, int count, bool needed,
                        absl::string_view what, absl::string_view field) {
  if (values == nullptr) {
    if (!needed) return absl::OkStatus();
    return absl::InvalidArgumentError(absl::StrCat(
        what, ".", field, ": expected ", count, " numbers, found NULL"));
  }
  for (int i = 0; i < count; ++i) {
    if (std::isfinite(static_cast<float>(values[i]))) continue;
    return absl::InvalidArgumentError(
        absl::StrCat(what, ".", field, "[", i,
                     "]: expected a finite float32, found ", values[i]));
  }
  return absl::OkStatus();
}

}  // namespace

absl::Status CheckPose(const Pose& pose, const PoseNeeds& needs,
                       absl::string_view what) {
  const struct {
    const double* values;
    int count;
    bool needed;
    absl::string_view name;
  } fields[] = {
      {pose.joint_position, needs.joints, true, "joint_position"},
      {pose.joint_velocity, needs.joints, true, "joint_velocity"},
      {pose.root_rotation, 4, true, "root_rotation"},
      {pose.root_angular_velocity, 3, true, "root_angular_velocity"},
      {pose.root_position, 3, needs.root, "root_position"},
      {pose.root_linear_velocity, 3, needs.root, "root_linear_velocity"},
      {pose.previous_target, needs.joints, false, "previous_target"},
      {pose.contact, needs.feet, needs.contact, "contact"},
      {pose.feedforward_torque, needs.joints, needs.torque,
       "feedforward_torque"}};
  for (const auto& field : fields) {
    SINEW_RETURN_IF_ERROR(
        CheckArray(field.values, field.count, field.needed, what, field.name));
  }
  const double* q = pose.root_rotation;
  const double norm =
      std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
  if (std::abs(norm - 1) <= kNormTolerance) return absl::OkStatus();
  return absl::InvalidArgumentError(absl::StrCat(
      what, ".root_rotation: expected a unit quaternion, found norm ", norm));
}

PoseBuffer::PoseBuffer(int joints)
    : joint_position_(joints), joint_velocity_(joints), torque_(joints) {
  pose_.joint_position = joint_position_.data();
  pose_.joint_velocity = joint_velocity_.data();
  pose_.root_rotation = root_rotation_;
  pose_.root_angular_velocity = root_angular_velocity_;
  pose_.root_position = root_position_;
  pose_.root_linear_velocity = root_linear_velocity_;
}

void PoseBuffer::Read(const character::Character& character,
                      const mjData& data) {
  const double* qpos = data.qpos + character.root_qpos_address();
  const double* qvel = data.qvel + character.root_dof_address();
  std::copy_n(qpos, 3, root_position_);
  std::copy_n(qpos + 3, 4, root_rotation_);
  std::copy_n(qvel, 3, root_linear_velocity_);
  std::copy_n(qvel + 3, 3, root_angular_velocity_);
  for (size_t j = 0; j < joint_position_.size(); ++j) {
    const character::JointInfo& joint = character.joints()[j];
    joint_position_[j] = data.qpos[joint.qpos_address];
    joint_velocity_[j] = data.qvel[joint.dof_address];
  }
  pose_.feedforward_torque = nullptr;
}

void PoseBuffer::Read(const motion::FrameView& frame) {
  const Eigen::Quaterniond rotation =
      motion::FromWxyz(frame.root_rotation).normalized();
  const Eigen::Vector3d local =
      rotation.conjugate() * Eigen::Vector3d(frame.root_angular_velocity[0],
                                             frame.root_angular_velocity[1],
                                             frame.root_angular_velocity[2]);
  motion::ToWxyz(rotation, root_rotation_);
  for (int i = 0; i < 3; ++i) {
    root_position_[i] = frame.root_position[i];
    root_linear_velocity_[i] = frame.root_linear_velocity[i];
    root_angular_velocity_[i] = local[i];
  }
  for (size_t j = 0; j < joint_position_.size(); ++j) {
    joint_position_[j] = frame.joint_position[j];
    joint_velocity_[j] = frame.joint_velocity[j];
    torque_[j] = frame.feedforward_torque[j];
  }
  pose_.feedforward_torque = torque_.data();
}

void PoseBuffer::Move(const Eigen::Quaterniond& turn,
                      const Eigen::Vector3d& offset) {
  Eigen::Map<Eigen::Vector3d> position(root_position_);
  Eigen::Map<Eigen::Vector3d> velocity(root_linear_velocity_);
  position = (turn * position + offset).eval();
  velocity = (turn * velocity).eval();
  motion::ToWxyz(turn * motion::FromWxyz(root_rotation_), root_rotation_);
}

void SetPose(const character::Character& character, const Pose& pose,
             mjData* data) {
  double* qpos = data->qpos + character.root_qpos_address();
  double* qvel = data->qvel + character.root_dof_address();
  for (int i = 0; i < 3; ++i) {
    qpos[i] = pose.root_position == nullptr ? 0 : pose.root_position[i];
    qvel[i] =
        pose.root_linear_velocity == nullptr ? 0 : pose.root_linear_velocity[i];
  }
  std::copy_n(pose.root_rotation, 4, qpos + 3);
  std::copy_n(pose.root_angular_velocity, 3, qvel + 3);
  for (size_t j = 0; j < character.joints().size(); ++j) {
    const character::JointInfo& joint = character.joints()[j];
    data->qpos[joint.qpos_address] = pose.joint_position[j];
    data->qvel[joint.dof_address] = pose.joint_velocity[j];
  }
}

}  // namespace sinew::runtime
