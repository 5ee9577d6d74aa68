#ifndef SINEW_SIM_IMPORT_RETARGET_DYNAMICS_H_
#define SINEW_SIM_IMPORT_RETARGET_DYNAMICS_H_

#include <mujoco/mujoco.h>

#include <Eigen/Dense>
#include <vector>

#include "sim/character/model_ptr.h"
#include "sim/import/retarget/import_model.h"
#include "sim/import/retarget/inverse_derivatives.h"
#include "sim/import/retarget/spatial.h"

namespace sinew::import {

// A point of the body that may push against the floor in one frame.
struct Contact {
  int point;                 // index into ImportModel::points
  Eigen::Vector3d position;  // of its lowest point, world
};

// Kinematics and inverse dynamics of a model without floor, limits, actuators
// and joint damping: what forces a motion takes. No more of MuJoCo's pipeline
// runs than that takes: a pose costs about ten microseconds.
//
// Thread-safety: one thread at a time (holds simulation data). Ownership: owns
// a copy of the model, borrows the ImportModel. Errors: none.
class Dynamics {
 public:
  explicit Dynamics(const ImportModel& import_model);

  const mjModel& model() const { return *model_; }
  const mjData& data() const { return *data_; }
  const ImportModel& import_model() const { return import_model_; }

  // Computes body poses and what Jacobians need.
  void SetPose(const Eigen::VectorXd& qpos);
  // Also body velocities.
  void SetState(const Eigen::VectorXd& qpos, const Eigen::VectorXd& qvel);

  // The following refer to the last SetPose, SetState or Inverse.

  // Lowest point of every ground point, world.
  std::vector<Eigen::Vector3d> LowestPoints() const;
  // Of one (an index into ImportModel::points), and its height alone.
  Eigen::Vector3d LowestPoint(int point) const;
  double Height(int point) const;
  // Of the lowest of all.
  double LowestHeight() const;
  // [3, nv] of a world point fixed to a body.
  Eigen::MatrixXd PointJacobian(int body, const Eigen::Vector3d& point) const;
  Eigen::Vector3d CentreOfMass() const;

  // Coordinates that move a body, ascending.
  const std::vector<int>& Chain(int body) const { return chains_[body]; }
  // How the world moves with a coordinate, about Pivot().
  Eigen::Map<const Vector6> Axis(int dof) const {
    return SpatialAt(data_->cdof, dof);
  }
  Eigen::Vector3d Pivot() const;

  // Generalised forces [nv] that this motion takes without contact: M a + c
  // less springs. The first six act on the root: force (world, N), torque (body
  // frame, Nm).
  Eigen::VectorXd Inverse(const Eigen::VectorXd& qpos,
                          const Eigen::VectorXd& qvel,
                          const Eigen::VectorXd& qacc);
  // The same in the pose that is set already.
  Eigen::VectorXd Inverse(const Eigen::VectorXd& qvel,
                          const Eigen::VectorXd& qacc);

  // Derivatives of the last Inverse, until the next call.
  const InverseDerivatives& DifferentiateInverse();

 private:
  const ImportModel& import_model_;
  character::ModelPtr model_;
  character::DataPtr data_;
  std::vector<std::vector<int>> chains_;  // [bodies]
  InverseDerivatives derivatives_;
};

}  // namespace sinew::import

#endif  // SINEW_SIM_IMPORT_RETARGET_DYNAMICS_H_
