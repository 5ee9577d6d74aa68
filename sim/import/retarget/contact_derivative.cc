#include "sim/import/retarget/contact_fit.h"

namespace sinew::import {
namespace {

using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;

// Forces on a body and all that it carries, about the pivot.
struct Load {
  bool any = false;
  Vector6 wrench = Vector6::Zero();
  // Moment that a motion (turn; slide) of the bodies adds, because the points
  // move and the forces do not: turning * turn + sliding * slide.
  Matrix3d turning = Matrix3d::Zero();
  Matrix3d sliding = Matrix3d::Zero();

  void Add(const Load& other) {
    any |= other.any;
    wrench += other.wrench;
    turning += other.turning;
    sliding += other.sliding;
  }
  Vector6 Change(const Vector6& motion) const {
    return MakeVector6(turning * motion.head<3>() + sliding * motion.tail<3>(),
                       Vector3d::Zero());
  }
};

// A point is the lowest of a ball whose centre moves with the body.
Load MakeLoad(const Dynamics& dynamics, const ContactForce& contact) {
  const Vector3d& f = contact.force;
  const Vector3d arm = contact.contact.position - dynamics.Pivot();
  const Vector3d centre =
      arm +
      Vector3d(0, 0,
               dynamics.import_model().points[contact.contact.point].radius);
  return {true, MakeVector6(arm.cross(f), f), Skew(f) * Skew(centre), -Skew(f)};
}

}  // namespace

// Force at j is axis_j' wrench. A coordinate i moves the axes of what it
// carries, and the points. The root's three turns carry each other.
MatrixXd ContactForceDerivative(const Dynamics& dynamics,
                                const std::vector<ContactForce>& forces) {
  const mjModel& model = dynamics.model();
  std::vector<Load> loads(model.nbody);
  for (const ContactForce& force : forces) {
    const int point = force.contact.point;
    loads[dynamics.import_model().points[point].body].Add(
        MakeLoad(dynamics, force));
  }
  for (int b = static_cast<int>(model.nbody) - 1; b > 0; --b) {
    if (loads[b].any) loads[model.body_parentid[b]].Add(loads[b]);
  }
  MatrixXd derivative = MatrixXd::Zero(model.nv, model.nv);
  for (int j = 0; j < model.nv; ++j) {
    const Load& load = loads[model.dof_bodyid[j]];
    if (!load.any) continue;
    const Vector6 axis = dynamics.Axis(j);
    const Vector6 change = load.Change(axis);
    for (int i = j; i >= 0; i = model.dof_parentid[i]) {
      const Vector6 carrier = dynamics.Axis(i);
      derivative(j, i) =
          axis.dot(load.Change(carrier) - CrossForce(carrier, load.wrench));
      const bool together = i >= 3 && j < 6;
      derivative(i, j) =
          together ? carrier.dot(change - CrossForce(axis, load.wrench))
                   : carrier.dot(change);
    }
  }
  return derivative;
}

}  // namespace sinew::import
