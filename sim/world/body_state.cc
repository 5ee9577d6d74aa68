#include "sim/world/body_state.h"

#include <cmath>

#include "sim/motion/rotation.h"

namespace sinew::world {
namespace {

template <typename Scalar>
Eigen::Vector3d Vector(const Scalar* xyz) {
  return Eigen::Vector3d(xyz[0], xyz[1], xyz[2]);
}

}  // namespace

BodyState::BodyState(int bodies, int joints)
    : position(bodies, Eigen::Vector3d::Zero()),
      rotation(bodies, Eigen::Quaterniond::Identity()),
      linear_velocity(bodies, Eigen::Vector3d::Zero()),
      angular_velocity(bodies, Eigen::Vector3d::Zero()),
      joint_position(joints, 0.0),
      joint_velocity(joints, 0.0) {}

Eigen::Quaterniond Heading(const Eigen::Quaterniond& rotation) {
  const double norm = std::hypot(rotation.w(), rotation.z());
  if (norm < 1e-9) return Eigen::Quaterniond::Identity();
  return Eigen::Quaterniond(rotation.w() / norm, 0, 0, rotation.z() / norm);
}

BodyReader::BodyReader(const character::Character& character) {
  for (int column : character.tracked()) {
    columns_.push_back(column);
    body_ids_.push_back(column + 1);
  }
  for (const character::JointInfo& joint : character.joints()) {
    qpos_addresses_.push_back(joint.qpos_address);
    dof_addresses_.push_back(joint.dof_address);
  }
}

void BodyReader::Refresh(const mjModel* model, mjData* data) {
  mj_kinematics(model, data);
  mj_comPos(model, data);
  mj_comVel(model, data);
}

void BodyReader::Read(const mjModel* model, const mjData* data,
                      BodyState* state) const {
  for (int i = 0; i < num_bodies(); ++i) {
    const int id = body_ids_[i];
    // cvel: angular, then linear velocity of the point of the body that is now
    // at the centre of mass of its kinematic tree.
    const Eigen::Vector3d angular = Vector(data->cvel + 6 * id);
    const Eigen::Vector3d position = Vector(data->xpos + 3 * id);
    const Eigen::Vector3d tree_com =
        Vector(data->subtree_com + 3 * model->body_rootid[id]);
    state->position[i] = position;
    state->rotation[i] = motion::FromWxyz(data->xquat + 4 * id);
    state->angular_velocity[i] = angular;
    state->linear_velocity[i] =
        Vector(data->cvel + 6 * id + 3) + angular.cross(position - tree_com);
  }
  for (int j = 0; j < num_joints(); ++j) {
    state->joint_position[j] = data->qpos[qpos_addresses_[j]];
    state->joint_velocity[j] = data->qvel[dof_addresses_[j]];
  }
}

void BodyReader::Read(const motion::FrameView& frame, BodyState* state) const {
  for (int i = 0; i < num_bodies(); ++i) {
    const int column = columns_[i];
    state->position[i] = Vector(frame.body_position + 3 * column);
    state->rotation[i] = motion::FromWxyz(frame.body_rotation + 4 * column);
    state->linear_velocity[i] = Vector(frame.body_linear_velocity + 3 * column);
    state->angular_velocity[i] =
        Vector(frame.body_angular_velocity + 3 * column);
  }
  for (int j = 0; j < num_joints(); ++j) {
    state->joint_position[j] = frame.joint_position[j];
    state->joint_velocity[j] = frame.joint_velocity[j];
  }
}

}  // namespace sinew::world
