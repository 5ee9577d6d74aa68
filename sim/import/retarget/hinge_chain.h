#ifndef SINEW_SIM_IMPORT_RETARGET_HINGE_CHAIN_H_
#define SINEW_SIM_IMPORT_RETARGET_HINGE_CHAIN_H_

#include <mujoco/mujoco.h>

#include <Eigen/Dense>
#include <Eigen/Geometry>
#include <vector>

namespace sinew::import {

// The hinges between two bodies of a model, in any number and order, as one
// rotation: child in parent = R(u1, a1) R(u2, a2) ... R(uk, ak) rest, with the
// axes u in the parent's frame at zero angles. Angles are qpos - qpos0.
//
// Thread-safety: const methods from any thread. Errors: none.
struct HingeChain {
  std::vector<int> joints;            // model joint ids, parent side first
  std::vector<Eigen::Vector3d> axes;  // unit
  std::vector<double> lower, upper;   // rad; +-infinity if unlimited
  Eigen::Quaterniond rest = Eigen::Quaterniond::Identity();

  int size() const { return static_cast<int>(axes.size()); }

  Eigen::Quaterniond Rotation(const Eigen::VectorXd& angles) const;

  // [3, k]: rotation vectors in the parent's frame per radian of each angle.
  Eigen::Matrix3Xd Jacobian(const Eigen::VectorXd& angles) const;

  // Angles that reach `target` (child in parent) exactly, or as nearly as the
  // axes allow: for three hinges both solutions of the generalised Euler
  // decomposition, else one. Limits are ignored; each angle is the
  // representative modulo 2 pi nearest to the middle of its range.
  std::vector<Eigen::VectorXd> Solve(const Eigen::Quaterniond& target) const;
};

// The chain from body `ancestor` down to body `body` of the model (equal
// bodies: an empty chain). Precondition: only hinges lie between.
HingeChain MakeHingeChain(const mjModel& model, int ancestor, int body);

}  // namespace sinew::import

#endif  // SINEW_SIM_IMPORT_RETARGET_HINGE_CHAIN_H_
