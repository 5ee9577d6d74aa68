#include "sim/import/retarget/contact_fit.h"

#include <algorithm>
#include <cmath>

#include "sim/import/retarget/push_fit.h"

namespace sinew::import {
namespace {

using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr int kEdges = 4;
// Cost of an edge force of one body weight against a body weight of residual.
constexpr double kForceCost = 1e-2;

Vector3d Edge(int index) {
  const double sign = index % 2 == 0 ? kFriction : -kFriction;
  return index < 2 ? Vector3d(sign, 0, 1) : Vector3d(0, sign, 1);
}

// The contacts of each body that has any: what PushFit makes of them.
struct BodyContacts {
  int body;
  std::vector<int> members;  // of the contacts
};

std::vector<BodyContacts> GroupByBody(const ImportModel& model,
                                      const std::vector<Contact>& contacts) {
  std::vector<BodyContacts> groups;
  for (size_t i = 0; i < contacts.size(); ++i) {
    const int body = model.points[contacts[i].point].body;
    auto group = std::find_if(
        groups.begin(), groups.end(),
        [body](const BodyContacts& other) { return other.body == body; });
    if (group == groups.end()) group = groups.insert(group, {body, {}});
    group->members.push_back(static_cast<int>(i));
  }
  return groups;
}

// Coordinates that move any of the bodies, ascending.
std::vector<int> MovingDofs(const Dynamics& dynamics,
                            const std::vector<BodyContacts>& groups) {
  std::vector<bool> moves(dynamics.model().nv);
  for (const BodyContacts& group : groups) {
    for (const int dof : dynamics.Chain(group.body)) moves[dof] = true;
  }
  std::vector<int> dofs;
  for (size_t dof = 0; dof < moves.size(); ++dof) {
    if (moves[dof]) dofs.push_back(static_cast<int>(dof));
  }
  return dofs;
}

// Pushes of one body weight along the edges of the friction cones.
PushGroup MakePushes(const Dynamics& dynamics,
                     const std::vector<Contact>& contacts,
                     const BodyContacts& group, const std::vector<int>& dofs,
                     const VectorXd& weights) {
  const double weight = dynamics.import_model().weight();
  const Vector3d pivot = dynamics.Pivot();
  const std::vector<int>& chain = dynamics.Chain(group.body);
  PushGroup pushes;
  pushes.map.setZero(static_cast<int>(dofs.size()), 6);
  for (size_t row = 0; row < dofs.size(); ++row) {
    const int dof = dofs[row];
    if (!std::binary_search(chain.begin(), chain.end(), dof)) continue;
    pushes.map.row(static_cast<int>(row)) =
        weight * weights[dof] * dynamics.Axis(dof).transpose();
  }
  pushes.wrenches.resize(6, static_cast<int>(group.members.size()) * kEdges);
  int column = 0;
  for (const int member : group.members) {
    const Vector3d arm = contacts[member].position - pivot;
    for (int e = 0; e < kEdges; ++e) {
      pushes.wrenches.col(column++) = MakeVector6(arm.cross(Edge(e)), Edge(e));
    }
  }
  return pushes;
}

// Takes one body's forces off the remainder.
void AddForces(const Dynamics& dynamics, const std::vector<Contact>& contacts,
               const BodyContacts& group, const VectorXd& pushes,
               const PushGroup& columns, ContactFit* fit) {
  const double weight = dynamics.import_model().weight();
  for (size_t i = 0; i < group.members.size(); ++i) {
    Vector3d force = Vector3d::Zero();
    for (int e = 0; e < kEdges; ++e) {
      force += weight * pushes[static_cast<int>(i) * kEdges + e] * Edge(e);
    }
    fit->forces.push_back({contacts[group.members[i]], force});
  }
  const Vector6 wrench = weight * (columns.wrenches * pushes);
  for (const int dof : dynamics.Chain(group.body)) {
    fit->remainder[dof] -= dynamics.Axis(dof).dot(wrench);
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
  const int count = static_cast<int>(dynamics.import_model().points.size());
  std::vector<Contact> contacts;
  for (int i = 0; i < count; ++i) {
    if (dynamics.Height(i) > margin) continue;
    contacts.push_back({i, dynamics.LowestPoint(i)});
  }
  return contacts;
}

ContactFit FitContacts(const Dynamics& dynamics,
                       const std::vector<Contact>& contacts,
                       const VectorXd& required, double joint_weight,
                       const VectorXd* guess) {
  const ImportModel& model = dynamics.import_model();
  const VectorXd weights = ContactFitWeights(model, joint_weight);
  ContactFit fit;
  fit.remainder = required;
  fit.cost = weights.cwiseProduct(required).squaredNorm();
  if (contacts.empty()) return fit;
  const std::vector<BodyContacts> groups = GroupByBody(model, contacts);
  fit.dofs = MovingDofs(dynamics, groups);
  const auto weighted = [&](const VectorXd& force) {
    VectorXd rows(static_cast<int>(fit.dofs.size()));
    for (int row = 0; row < rows.size(); ++row) {
      rows[row] = weights[fit.dofs[row]] * force[fit.dofs[row]];
    }
    return rows;
  };
  std::vector<PushGroup> columns;
  for (const BodyContacts& group : groups) {
    columns.push_back(MakePushes(dynamics, contacts, group, fit.dofs, weights));
  }
  const VectorXd target = weighted(required);
  PushFit solver(columns, target, kForceCost);
  solver.Solve(guess == nullptr ? target : weighted(*guess));
  fit.cost = 0;
  for (size_t g = 0; g < groups.size(); ++g) {
    const VectorXd pushes = solver.Pushes(static_cast<int>(g));
    AddForces(dynamics, contacts, groups[g], pushes, columns[g], &fit);
    fit.cost += kForceCost * kForceCost * pushes.squaredNorm();
  }
  fit.cost += weights.cwiseProduct(fit.remainder).squaredNorm();
  fit.factor = solver.factor();
  return fit;
}

}  // namespace sinew::import
