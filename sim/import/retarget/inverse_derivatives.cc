#include "sim/import/retarget/inverse_derivatives.h"

namespace sinew::import {
namespace {

using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;

// MuJoCo's packed inertia: xx yy zz xy xz yz, mass times centre, mass.
Matrix6 Unpack(const double* packed) {
  const Matrix3d first_moment = Skew(Vector3d(packed[6], packed[7], packed[8]));
  Matrix6 inertia;
  inertia.topLeftCorner<3, 3>() << packed[0], packed[3], packed[4], packed[3],
      packed[1], packed[5], packed[4], packed[5], packed[2];
  inertia.topRightCorner<3, 3>() = first_moment;
  inertia.bottomLeftCorner<3, 3>() = -first_moment;
  inertia.bottomRightCorner<3, 3>() = packed[9] * Matrix3d::Identity();
  return inertia;
}

// C of one body: x -> v x* I x - I (v x x) + x x* I v.
Matrix6 VelocityChange(const Vector6& velocity, const Matrix6& inertia) {
  const Matrix3d turn = Skew(velocity.head<3>());
  const Matrix3d slide = Skew(velocity.tail<3>());
  Matrix6 cross = Matrix6::Zero();  // v x*, also minus the transpose of v x
  cross.topLeftCorner<3, 3>() = turn;
  cross.topRightCorner<3, 3>() = slide;
  cross.bottomRightCorner<3, 3>() = turn;
  const Matrix6 moved = cross * inertia;
  const Vector6 momentum = inertia * velocity;
  const Matrix3d force = Skew(momentum.tail<3>());
  Matrix6 change = moved + moved.transpose();
  change.topLeftCorner<3, 3>() -= Skew(momentum.head<3>());
  change.topRightCorner<3, 3>() -= force;
  change.bottomLeftCorner<3, 3>() -= force;
  return change;
}

}  // namespace

InverseDerivatives::InverseDerivatives(const mjModel& model)
    : model_(model),
      turn_(model.nv),
      bodies_(model.nbody),
      axes_(model.nv),
      position_(MatrixXd::Zero(model.nv, model.nv)),
      velocity_(position_),
      acceleration_(position_) {
  for (int dof = 0; dof < model.nv;) {
    const int width = Width(dof);
    for (int k = 0; k < width; ++k) turn_[dof + k] = dof;
    dof += width;
  }
}

int InverseDerivatives::Width(int dof) const {
  const int joint = model_.dof_jntid[dof];
  const int type = model_.jnt_type[joint];
  const bool turns =
      type == mjJNT_BALL ||
      (type == mjJNT_FREE && dof - model_.jnt_dofadr[joint] >= 3);
  return turns ? 3 : 1;
}

void InverseDerivatives::Compute(const mjData& data) {
  Body& world = bodies_[0];
  world.velocity.setZero();
  world.acceleration.setZero();
  if (!(model_.opt.disableflags & mjDSBL_GRAVITY)) {
    world.acceleration.tail<3>() =
        -Eigen::Map<const Vector3d>(model_.opt.gravity);
  }
  for (int b = 1; b < model_.nbody; ++b) {
    MoveBody(data, b);
    Weigh(data, b);
  }
  for (int b = static_cast<int>(model_.nbody) - 1; b > 0; --b) {
    const int parent = model_.body_parentid[b];
    if (parent == 0) continue;
    bodies_[parent].force += bodies_[b].force;
    bodies_[parent].inertia += bodies_[b].inertia;
    bodies_[parent].change += bodies_[b].change;
  }
  for (int dof = 0; dof < model_.nv; ++dof) Fill(dof);
}

// Coordinate after coordinate carries the next one.
void InverseDerivatives::MoveBody(const mjData& data, int body) {
  const Body& parent = bodies_[model_.body_parentid[body]];
  Vector6 velocity = parent.velocity;
  Vector6 acceleration = parent.acceleration;
  const int first = model_.body_dofadr[body];
  const int end = first + model_.body_dofnum[body];
  for (int dof = first; dof < end;) {
    const Vector6 carrier_velocity = velocity;
    const Vector6 carrier_acceleration = acceleration;
    const int width = Width(dof);
    for (int j = dof; j < dof + width; ++j) {
      Axis& axis = axes_[j];
      axis.axis = SpatialAt(data.cdof, j);
      axis.rate = SpatialAt(data.cdof_dot, j);
      axis.second = CrossMotion(carrier_acceleration, axis.axis) +
                    CrossMotion(carrier_velocity, axis.rate);
      velocity += axis.axis * data.qvel[j];
      acceleration += axis.rate * data.qvel[j] + axis.axis * data.qacc[j];
    }
    for (int j = dof; j < dof + width; ++j) {
      axes_[j].both_rates =
          axes_[j].rate + CrossMotion(velocity, axes_[j].axis);
    }
    dof += width;
  }
  bodies_[body].velocity = velocity;
  bodies_[body].acceleration = acceleration;
}

void InverseDerivatives::Weigh(const mjData& data, int index) {
  Body& body = bodies_[index];
  body.inertia = Unpack(data.cinert + 10 * index);
  body.change = VelocityChange(body.velocity, body.inertia);
  body.force = body.inertia * body.acceleration +
               CrossForce(body.velocity, body.inertia * body.velocity);
}

void InverseDerivatives::Fill(int j) {
  const Body& body = bodies_[model_.dof_bodyid[j]];
  const Axis& axis = axes_[j];
  const Vector6 momentum = body.inertia * axis.axis;
  const Vector6 back = body.change.transpose() * axis.axis;
  const Vector6 by_velocity =
      body.change * axis.axis + body.inertia * axis.both_rates;
  const Vector6 by_position =
      body.change * axis.rate + body.inertia * axis.second;
  const Vector6 lifted = by_position + CrossForce(axis.axis, body.force);
  for (int i = j; i >= 0; i = model_.dof_parentid[i]) {
    const Axis& carrier = axes_[i];
    acceleration_(i, j) = acceleration_(j, i) = carrier.axis.dot(momentum);
    velocity_(i, j) = carrier.axis.dot(by_velocity);
    velocity_(j, i) = back.dot(carrier.axis) + momentum.dot(carrier.both_rates);
    position_(i, j) =
        carrier.axis.dot(turn_[i] == turn_[j] ? by_position : lifted);
    position_(j, i) = back.dot(carrier.rate) + momentum.dot(carrier.second);
  }
  acceleration_(j, j) += model_.dof_armature[j];
  const int joint = model_.dof_jntid[j];
  const int type = model_.jnt_type[joint];
  if (type == mjJNT_HINGE || type == mjJNT_SLIDE) {
    position_(j, j) += model_.jnt_stiffness[joint];
  }
}

}  // namespace sinew::import
