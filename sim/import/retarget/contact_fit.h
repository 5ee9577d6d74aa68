#ifndef SINEW_SIM_IMPORT_RETARGET_CONTACT_FIT_H_
#define SINEW_SIM_IMPORT_RETARGET_CONTACT_FIT_H_

#include <Eigen/Dense>
#include <vector>

#include "sim/import/retarget/dynamics.h"

namespace sinew::import {

// Floor contact as an explanation of a motion. The floor pushes at contact
// points with forces in the friction cone (four edges, coefficient 1); the
// forces are those that leave least on the root's six degrees of freedom, and
// among those spread the load and spare the joints:
//   minimise |W (b - A x)|^2 + |x|^2 small, x >= 0,
// b the generalised forces of inverse dynamics, A x those of the contacts, W in
// body weights for root force, body weights times kTorqueArm for root torque,
// and lightly in torque limits for joints.

// Points no higher than this may bear, metres.
inline constexpr double kContactMargin = 0.02;
// Root torque that counts like one body weight of force, per body weight, m.
inline constexpr double kTorqueArm = 0.3;
inline constexpr double kFriction = 1.0;
// A joint torque at its limit counts like this much body weight.
inline constexpr double kJointWeight = 0.02;

struct ContactForce {
  Contact contact;
  Eigen::Vector3d force;  // world, N
};

struct ContactFit {
  std::vector<ContactForce> forces;
  // Generalised forces that contact does not explain, [nv]: on the root the
  // residual, on hinges the actuator torques.
  Eigen::VectorXd remainder;
  // What was minimised.
  double cost = 0;
  // What is left of a change of the weighted required forces after the floor's
  // have adapted to it: on the coordinates `dofs` (ascending; those that move a
  // body in contact) (L L')^-1 of it, with L the lower half of `factor`;
  // elsewhere all. For whoever minimises the cost over motions (variable
  // projection).
  std::vector<int> dofs;
  Eigen::MatrixXd factor;
};

// W, [nv]. `joint_weight`: of a joint at its torque limit against a body weight
// of root force.
Eigen::VectorXd ContactFitWeights(const ImportModel& model,
                                  double joint_weight);

// Points of the pose in `dynamics` that may bear.
std::vector<Contact> FindContacts(const Dynamics& dynamics,
                                  double margin = kContactMargin);

// Fits forces at `contacts` to `required` (Dynamics::Inverse of this motion).
// `dynamics` must hold the frame's pose. `guess`: the remainder in a similar
// frame, to start from; the result is the same without.
ContactFit FitContacts(const Dynamics& dynamics,
                       const std::vector<Contact>& contacts,
                       const Eigen::VectorXd& required,
                       double joint_weight = kJointWeight,
                       const Eigen::VectorXd* guess = nullptr);

// Derivative [nv, nv] of the generalised forces of `forces` (constant world
// forces at the lowest points, which move with their bodies) by the tangent
// coordinates of the pose in `dynamics`.
Eigen::MatrixXd ContactForceDerivative(const Dynamics& dynamics,
                                       const std::vector<ContactForce>& forces);

}  // namespace sinew::import

#endif  // SINEW_SIM_IMPORT_RETARGET_CONTACT_FIT_H_
