#include "sim/world/body_state.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <new>

#include "common/math/double4.h"
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

BodyReader::BodyReader(const character::Character& character)
    : columns_(character.tracked()) {
  AddBodies(character);
  for (const character::JointInfo& joint : character.joints()) {
    joints_.push_back({joint.qpos_address, joint.dof_address});
  }
}

// A character is one tree: a free joint at its root (body 1), hinges below.
void BodyReader::AddBodies(const character::Character& character) {
  const mjModel* model = character.model();
  root_qpos_address_ = character.root_qpos_address();
  root_dof_address_ = character.root_dof_address();
  std::vector<bool> counts(model->nbody, false);
  std::vector<int> tracked(model->nbody, -1);
  counts[1] = true;
  for (size_t i = 0; i < columns_.size(); ++i) {
    const int id = columns_[i] + 1;
    tracked[id] = static_cast<int>(i);
    for (int b = id; b > 1; b = model->body_parentid[b]) counts[b] = true;
  }
  std::vector<int> index(model->nbody, 0);
  for (int id = 1; id < model->nbody; ++id) {
    if (!counts[id]) continue;
    index[id] = static_cast<int>(bodies_.size());
    const Eigen::Quaterniond rotation =
        motion::FromWxyz(model->body_quat + 4 * id);
    Body body = {.parent = index[model->body_parentid[id]],
                 .position = Vector(model->body_pos + 3 * id),
                 .rotation = rotation,
                 .is_turned = rotation.vec() != Eigen::Vector3d::Zero(),
                 .first_hinge = static_cast<int>(hinges_.size()),
                 .end_hinge = 0,
                 .tracked = tracked[id]};
    const int first = model->body_jntadr[id];
    for (int j = first; id > 1 && j < first + model->body_jntnum[id]; ++j) {
      const Eigen::Vector3d anchor = Vector(model->jnt_pos + 3 * j);
      hinges_.push_back({.qpos_address = model->jnt_qposadr[j],
                         .dof_address = model->jnt_dofadr[j],
                         .rest = model->qpos0[model->jnt_qposadr[j]],
                         .axis = Vector(model->jnt_axis + 3 * j),
                         .anchor = anchor,
                         .has_anchor = anchor != Eigen::Vector3d::Zero()});
    }
    body.end_hinge = static_cast<int>(hinges_.size());
    bodies_.push_back(body);
  }
}

struct BodyReader::Motion {
  Eigen::Quaterniond rotation;
  Eigen::Vector3d position, linear_velocity, angular_velocity;

  // Moves the point that position and linear velocity are of.
  void MoveBy(const Eigen::Vector3d& arm) {
    position += arm;
    linear_velocity += angular_velocity.cross(arm);
  }
};

void BodyReader::ReadHalfAngles(const double* qpos, double* sines,
                                double* cosines) const {
  for (size_t h = 0; h < hinges_.size(); h += 4) {
    Double4 half = Splat4(0);
    for (size_t i = h; i < std::min(h + 4, hinges_.size()); ++i) {
      half[i - h] = (qpos[hinges_[i].qpos_address] - hinges_[i].rest) / 2;
    }
    const SinCos4 result = SinCos(half);
    std::memcpy(sines + h, &result.sin, sizeof result.sin);
    std::memcpy(cosines + h, &result.cos, sizeof result.cos);
  }
}

BodyReader::Motion BodyReader::RootMotion(const mjData& data) const {
  const double* q = data.qpos + root_qpos_address_;
  const double* v = data.qvel + root_dof_address_;
  Motion root;
  root.rotation = motion::FromWxyz(q + 3).normalized();
  root.position = Vector(q);
  root.linear_velocity = Vector(v);
  root.angular_velocity = root.rotation * Vector(v + 3);
  return root;
}

BodyReader::Motion BodyReader::Follow(const Body& body, const Motion& parent,
                                      const double* sines,
                                      const double* cosines,
                                      const double* qvel) const {
  Motion motion = parent;
  motion.MoveBy(parent.rotation * body.position);
  if (body.is_turned) motion.rotation = parent.rotation * body.rotation;
  for (int h = body.first_hinge; h < body.end_hinge; ++h) {
    const Hinge& hinge = hinges_[h];
    const Eigen::Vector3d axis = motion.rotation * hinge.axis;
    if (hinge.has_anchor) motion.MoveBy(motion.rotation * hinge.anchor);
    Eigen::Quaterniond turn;
    turn.w() = cosines[h];
    turn.vec() = sines[h] * hinge.axis;
    motion.rotation = motion.rotation * turn;
    motion.angular_velocity += qvel[hinge.dof_address] * axis;
    if (hinge.has_anchor) motion.MoveBy(motion.rotation * -hinge.anchor);
  }
  return motion;
}

void BodyReader::Read(mjData* data, BodyState* state) const {
  mj_markStack(data);
  auto* motions = static_cast<Motion*>(mj_stackAllocByte(
      data, bodies_.size() * sizeof(Motion), alignof(Motion)));
  double* sines = mj_stackAllocNum(data, hinges_.size() + 3);
  double* cosines = mj_stackAllocNum(data, hinges_.size() + 3);
  ReadHalfAngles(data->qpos, sines, cosines);
  for (size_t b = 0; b < bodies_.size(); ++b) {
    const Body& body = bodies_[b];
    const Motion& motion =
        *new (motions + b) Motion(b == 0 ? RootMotion(*data)
                                         : Follow(body, motions[body.parent],
                                                  sines, cosines, data->qvel));
    if (body.tracked < 0) continue;
    state->position[body.tracked] = motion.position;
    state->rotation[body.tracked] = motion.rotation;
    state->linear_velocity[body.tracked] = motion.linear_velocity;
    state->angular_velocity[body.tracked] = motion.angular_velocity;
  }
  mj_freeStack(data);
  for (int j = 0; j < num_joints(); ++j) {
    state->joint_position[j] = data->qpos[joints_[j].qpos_address];
    state->joint_velocity[j] = data->qvel[joints_[j].dof_address];
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
