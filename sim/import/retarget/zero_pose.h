#ifndef SINEW_SIM_IMPORT_RETARGET_ZERO_POSE_H_
#define SINEW_SIM_IMPORT_RETARGET_ZERO_POSE_H_

#include <mujoco/mujoco.h>

#include <Eigen/Geometry>
#include <vector>

namespace sinew::import {

// World poses of bodies with all hinges at qpos0, the root at the origin with
// an identity rotation.
struct ZeroPose {
  std::vector<Eigen::Vector3d> position;     // [nbody]
  std::vector<Eigen::Quaterniond> rotation;  // [nbody]

  ZeroPose(const mjModel& model, int root);

  // The point nearest to the axes of all hinges given (their common centre if
  // they have one, as for a shoulder of three), world. One hinge: its anchor.
  Eigen::Vector3d Centre(const mjModel& model,
                         const std::vector<int>& joints) const;
};

}  // namespace sinew::import

#endif  // SINEW_SIM_IMPORT_RETARGET_ZERO_POSE_H_
