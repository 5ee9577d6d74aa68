#include "sim/import/contact_fit.h"

#include <algorithm>
#include <cmath>

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

VectorXd Weights(const ImportModel& model, double joint_weight) {
  VectorXd weights = VectorXd::Zero(model.model->nv);
  weights.head<6>() = RootWeights(model);
  for (const ImportJoint& joint : model.joints) {
    weights[joint.dof_address] = joint_weight / joint.torque_limit;
  }
  return weights;
}

// Minimises x' H x / 2 + g' x over x >= 0.
VectorXd SolveNonNegative(const MatrixXd& hessian, const VectorXd& gradient) {
  const int n = static_cast<int>(gradient.size());
  const VectorXd lower = VectorXd::Zero(n);
  const VectorXd upper = VectorXd::Constant(n, 1e3);
  VectorXd x = VectorXd::Zero(n);
  std::vector<double> factor(static_cast<size_t>(n) * (n + 7));
  std::vector<int> index(n);
  // A failed line search leaves the best point so far, which is feasible.
  mju_boxQP(x.data(), factor.data(), index.data(), hessian.data(),
            gradient.data(), n, lower.data(), upper.data());
  return x.cwiseMax(0.0);
}

// I - A (A' A + R)^-1 A' over the columns whose force is not zero: the root
// rows' part of what forces cannot follow.
Eigen::Matrix<double, 6, 6> Sensitivity(const MatrixXd& root_columns,
                                        const VectorXd& x) {
  std::vector<int> free;
  for (int i = 0; i < x.size(); ++i) {
    if (x[i] > 1e-9) free.push_back(i);
  }
  Eigen::Matrix<double, 6, 6> sensitivity =
      Eigen::Matrix<double, 6, 6>::Identity();
  if (free.empty()) return sensitivity;
  const MatrixXd columns = root_columns(Eigen::all, free);
  MatrixXd normal = columns.transpose() * columns;
  normal.diagonal().array() += kForceCost * kForceCost;
  sensitivity -= columns * normal.ldlt().solve(columns.transpose());
  return sensitivity;
}

}  // namespace

Eigen::Matrix<double, 6, 1> RootWeights(const ImportModel& model) {
  Eigen::Matrix<double, 6, 1> weights;
  weights.head<3>().setConstant(1 / model.weight());
  weights.tail<3>().setConstant(1 / (model.weight() * kTorqueArm));
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
  ContactFit fit;
  fit.remainder = required;
  fit.sensitivity.setIdentity();
  if (contacts.empty()) return fit;
  const VectorXd weights = Weights(model, joint_weight);
  const MatrixXd forces = EdgeForces(dynamics, contacts);
  const MatrixXd columns = weights.asDiagonal() * forces;
  MatrixXd hessian = columns.transpose() * columns;
  hessian.diagonal().array() += kForceCost * kForceCost;
  const VectorXd x = SolveNonNegative(
      hessian, -columns.transpose() * weights.cwiseProduct(required));
  fit.remainder -= forces * x;
  fit.sensitivity = Sensitivity(columns.topRows<6>(), x);
  for (size_t i = 0; i < contacts.size(); ++i) {
    Vector3d force = Vector3d::Zero();
    for (int e = 0; e < kEdges; ++e) {
      force += model.weight() * x[static_cast<int>(i) * kEdges + e] * Edge(e);
    }
    fit.forces.push_back({contacts[i], force});
  }
  return fit;
}

}  // namespace sinew::import
