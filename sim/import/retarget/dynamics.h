#ifndef SINEW_SIM_IMPORT_RETARGET_DYNAMICS_H_
#define SINEW_SIM_IMPORT_RETARGET_DYNAMICS_H_

#include <mujoco/mujoco.h>

#include <Eigen/Dense>
#include <vector>

#include "sim/character/model_ptr.h"
#include "sim/import/retarget/import_model.h"

namespace sinew::import {

// A point of the body that may push against the floor in one frame.
struct Contact {
  int point;                 // index into ImportModel::points
  Eigen::Vector3d position;  // of its lowest point, world
};

// Kinematics and inverse dynamics of a model without floor, limits, actuators
// and joint damping: what forces a motion takes.
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

  // The following refer to the last SetPose or SetState.

  // Lowest point of every ground point, world.
  std::vector<Eigen::Vector3d> LowestPoints() const;
  // [3, nv] of a world point fixed to a body.
  Eigen::MatrixXd PointJacobian(int body, const Eigen::Vector3d& point) const;
  Eigen::Vector3d CentreOfMass() const;

  // Generalised forces [nv] that this motion takes without contact: M a + c
  // less springs. The first six act on the root: force (world, N), torque (body
  // frame, Nm).
  Eigen::VectorXd Inverse(const Eigen::VectorXd& qpos,
                          const Eigen::VectorXd& qvel,
                          const Eigen::VectorXd& qacc);

  // Derivatives of Inverse, [nv, nv] each, row = force, column = coordinate
  // (tangent of qpos, qvel, qacc), by finite differences.
  struct Derivatives {
    Eigen::MatrixXd position, velocity, acceleration;
  };
  Derivatives InverseDerivatives(const Eigen::VectorXd& qpos,
                                 const Eigen::VectorXd& qvel,
                                 const Eigen::VectorXd& qacc);

 private:
  void SetAll(const Eigen::VectorXd& qpos, const Eigen::VectorXd& qvel,
              const Eigen::VectorXd& qacc);

  const ImportModel& import_model_;
  character::ModelPtr model_;
  character::DataPtr data_;
};

}  // namespace sinew::import

#endif  // SINEW_SIM_IMPORT_RETARGET_DYNAMICS_H_
