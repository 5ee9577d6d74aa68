#ifndef SINEW_DEPLOY_RUNTIME_ROOT_ESTIMATE_H_
#define SINEW_DEPLOY_RUNTIME_ROOT_ESTIMATE_H_

#include <mujoco/mujoco.h>

#include <Eigen/Core>

#include "sim/character/character.h"

namespace sinew::runtime {

// What an IMU and joint encoders say about the root's height and velocity, if
// the foot whose sole is lowest stands still on the floor.
struct RootEstimate {
  double height = 0;  // of the root above the floor, m
  Eigen::Vector3d linear_velocity = Eigen::Vector3d::Zero();  // world, m/s
};

// From a data whose qpos has the root's rotation (its position is of no
// matter) and the joints, whose qvel has the root's angular velocity and the
// joints', with the root's linear velocity zero. With p the lowest point of the
// soles:
//   height = z of the root - z of p
//   linear velocity = - velocity of p
// Wrong while no foot bears weight. Leaves in the data what mj_kinematics,
// mj_comPos and mj_comVel compute at the standing height, and moves the root in
// qpos to the height found.
//
// Thread-safety: one caller per data. Blocking: never; nothing allocates.
// Errors: none.
RootEstimate EstimateRoot(const character::Character& character, mjData* data);

}  // namespace sinew::runtime

#endif  // SINEW_DEPLOY_RUNTIME_ROOT_ESTIMATE_H_
