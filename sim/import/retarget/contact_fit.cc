#include "sim/import/retarget/contact_fit.h"

#include <algorithm>
#include <cmath>

#include "sim/motion/rotation.h"

namespace sinew::import {
namespace {

using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr int kEdges = 4;
// Cost of an edge force of one body weight against a body weight of residual.
constexpr double kForceCost = 1e-2;

Vector3d Edge(int index) {
  const double sign = index % 2 == 0 ? kFriction : -kFriction;
  return index < 2 ? Vector3d(sign, 0, 1) : Vector3d(0, sign, 1);
}

// Generalised force per body weight along each edge, [nv, edges].
MatrixXd EdgeForces(const Dynamics& dynamics,
                    const std::vector<Contact>& contacts) {
  const ImportModel& model = dynamics.import_model();
  MatrixXd forces(model.model->nv,
                  static_cast<int>(contacts.size()) * kEdges);
  for (size_t i = 0; i < contacts.size(); ++i) {
    const MatrixXd jacobian = dynamics.PointJacobian(
        model.points[contacts[i].point].body, contacts[i].position);
    for (int e = 0; e < kEdges; ++e) {
      forces.col(static_cast<int>(i) * kEdges + e) =
          model.weight() * jacobian.transpose() * Edge(e);
    }
  }
  return forces;
}

// Solution of: minimise |b - A x|^2 + c^2 |x|^2 over x >= 0.
struct NonNegative {
  VectorXd x;
  VectorXd remainder;  // r = b - A x
  MatrixXd change;     // derivative of r by b
};

// By its dual. Optimal are exactly x = max(0, A' r) / c^2 with r = b - A x, so
// r minimises the convex
//   f(r) = |r|^2 / 2 + |max(0, A' r)|^2 / 2 c^2 - b' r,
// piecewise quadratic and of few unknowns however many columns A has: Newton's
// method with step halving ends after a few pieces.
class DualNewton {
 public:
  DualNewton(const MatrixXd& columns, const VectorXd& target, double cost)
      : columns_(columns), target_(target), scale_(1 / (cost * cost)) {}

  NonNegative Solve() const {
    constexpr int kIterations = 100;
    VectorXd r = target_;
    for (int i = 0; i < kIterations; ++i) {
      const VectorXd gradient = Gradient(r);
      if (gradient.norm() <= 1e-12 * (1 + target_.norm())) break;
      const VectorXd step = -Hessian(r).llt().solve(gradient);
      const double value = Value(r);
      const double slope = gradient.dot(step);
      double length = 1;
      while (length > 1e-9 &&
             Value(r + length * step) > value + 1e-4 * length * slope) {
        length /= 2;
      }
      r += length * step;
    }
    NonNegative solution;
    solution.x = scale_ * (columns_.transpose() * r).cwiseMax(0.0);
    solution.remainder = target_ - columns_ * solution.x;
    const auto n = target_.size();
    solution.change = Hessian(r).llt().solve(MatrixXd::Identity(n, n));
    return solution;
  }

 private:
  double Value(const VectorXd& r) const {
    return r.squaredNorm() / 2 - target_.dot(r) +
           scale_ / 2 * (columns_.transpose() * r).cwiseMax(0.0).squaredNorm();
  }
  VectorXd Gradient(const VectorXd& r) const {
    return r - target_ +
           scale_ * (columns_ * (columns_.transpose() * r).cwiseMax(0.0));
  }
  MatrixXd Hessian(const VectorXd& r) const {
    const VectorXd pushes = columns_.transpose() * r;
    const auto n = target_.size();
    MatrixXd hessian = MatrixXd::Identity(n, n);
    for (int i = 0; i < pushes.size(); ++i) {
      if (pushes[i] <= 0) continue;
      hessian += scale_ * columns_.col(i) * columns_.col(i).transpose();
    }
    return hessian;
  }

  const MatrixXd& columns_;
  const VectorXd& target_;
  const double scale_;
};

// One coordinate of the pose as a motion of the world: along `axis`, or about
// it through `anchor`.
struct Screw {
  bool turns;
  Vector3d axis;
  Vector3d anchor;

  Vector3d Move(const Vector3d& point) const {
    return turns ? axis.cross(point - anchor).eval() : axis;
  }
};

Screw MakeScrew(const Dynamics& dynamics, int dof) {
  const mjData& data = dynamics.data();
  const int joint = dynamics.model().dof_jntid[dof];
  if (dof < 3) return {false, Vector3d::Unit(dof), Vector3d::Zero()};
  if (dof < 6) {
    const int root = dynamics.model().jnt_bodyid[joint];
    return {true,
            motion::FromWxyz(data.xquat + 4 * root) * Vector3d::Unit(dof - 3),
            Eigen::Map<const Vector3d>(data.xpos + 3 * root)};
  }
  return {true, Eigen::Map<const Vector3d>(data.xaxis + 3 * joint),
          Eigen::Map<const Vector3d>(data.xanchor + 3 * joint)};
}

// Coordinate j's force is axis_j . ((p - anchor_j) x f), or axis_j . f; what
// lies between the root and j moves its axis and anchor, what lies between the
// root and the contact moves p. The root's three turns move each other's axes.
void AddForceDerivative(const Dynamics& dynamics, const ContactForce& contact,
                        MatrixXd* derivative) {
  const mjModel& model = dynamics.model();
  const GroundPoint& point =
      dynamics.import_model().points[contact.contact.point];
  const Vector3d& f = contact.force;
  const Vector3d p = contact.contact.position;
  const Vector3d centre = p + Vector3d(0, 0, point.radius);
  std::vector<int> dofs;
  std::vector<Screw> screws;
  int body = point.body;
  while (model.body_dofnum[body] == 0) body = model.body_parentid[body];
  for (int dof = model.body_dofadr[body] + model.body_dofnum[body] - 1;
       dof >= 0; dof = model.dof_parentid[dof]) {
    dofs.push_back(dof);
    screws.push_back(MakeScrew(dynamics, dof));
  }
  for (size_t j = 0; j < dofs.size(); ++j) {
    if (!screws[j].turns) continue;
    const Vector3d arm = p - screws[j].anchor;
    for (size_t i = 0; i < dofs.size(); ++i) {
      const bool carries =
          dofs[i] < dofs[j] || (dofs[i] < 6 && dofs[j] < 6);
      Vector3d axis_moves = Vector3d::Zero();
      Vector3d arm_moves = screws[i].Move(centre);
      if (carries && screws[i].turns) {
        axis_moves = screws[i].axis.cross(screws[j].axis);
      }
      if (carries) arm_moves -= screws[i].Move(screws[j].anchor);
      (*derivative)(dofs[j], dofs[i]) +=
          axis_moves.dot(arm.cross(f)) +
          screws[j].axis.dot(arm_moves.cross(f));
    }
  }
}

}  // namespace

VectorXd ContactFitWeights(const ImportModel& model, double joint_weight) {
  VectorXd weights = VectorXd::Zero(model.model->nv);
  weights.head<3>().setConstant(1 / model.weight());
  weights.segment<3>(3).setConstant(1 / (model.weight() * kTorqueArm));
  for (const ImportJoint& joint : model.joints) {
    weights[joint.dof_address] = joint_weight / joint.torque_limit;
  }
  return weights;
}

std::vector<Contact> FindContacts(const Dynamics& dynamics, double margin) {
  const std::vector<Vector3d> lowest = dynamics.LowestPoints();
  std::vector<Contact> contacts;
  for (size_t i = 0; i < lowest.size(); ++i) {
    if (lowest[i].z() <= margin) {
      contacts.push_back({static_cast<int>(i), lowest[i]});
    }
  }
  return contacts;
}

ContactFit FitContacts(const Dynamics& dynamics,
                       const std::vector<Contact>& contacts,
                       const VectorXd& required, double joint_weight) {
  const ImportModel& model = dynamics.import_model();
  const VectorXd weights = ContactFitWeights(model, joint_weight);
  const VectorXd target = weights.cwiseProduct(required);
  ContactFit fit;
  fit.remainder = required;
  fit.cost = target.squaredNorm();
  fit.sensitivity.setIdentity(model.model->nv, model.model->nv);
  if (contacts.empty()) return fit;
  const MatrixXd forces = EdgeForces(dynamics, contacts);
  const MatrixXd columns = weights.asDiagonal() * forces;
  const NonNegative solution =
      DualNewton(columns, target, kForceCost).Solve();
  fit.remainder -= forces * solution.x;
  fit.cost = solution.remainder.squaredNorm() +
             kForceCost * kForceCost * solution.x.squaredNorm();
  fit.sensitivity = solution.change;
  for (size_t i = 0; i < contacts.size(); ++i) {
    Vector3d force = Vector3d::Zero();
    for (int e = 0; e < kEdges; ++e) {
      force += model.weight() *
               solution.x[static_cast<int>(i) * kEdges + e] * Edge(e);
    }
    fit.forces.push_back({contacts[i], force});
  }
  return fit;
}

MatrixXd ContactForceDerivative(const Dynamics& dynamics,
                                const std::vector<ContactForce>& forces) {
  const int nv = dynamics.model().nv;
  MatrixXd derivative = MatrixXd::Zero(nv, nv);
  for (const ContactForce& force : forces) {
    AddForceDerivative(dynamics, force, &derivative);
  }
  return derivative;
}

}  // namespace sinew::import
