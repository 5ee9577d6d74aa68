#ifndef SINEW_SIM_WORLD_BODY_GOAL_H_
#define SINEW_SIM_WORLD_BODY_GOAL_H_

#include <Eigen/Geometry>
#include <string>
#include <vector>

#include "sim/world/body_state.h"
#include "sim/world/observation_writer.h"

namespace sinew::world {

// Goals in body space, as PHC has them (Luo et al. 2023): what a reference
// frame asks of every tracked body b, in the heading frame of the body. h is
// the rotation by its heading, r its root, hats are the reference; body after
// body, and for each
//
// keypoints, 9:
//   position difference          3   h^-1 (p^_b - p_b), m
//   linear velocity difference   3   h^-1 (v^_b - v_b), m/s
//   position                     3   h^-1 (p^_b - p_r), m
// bodies, 24:
//   position difference          3
//   rotation difference          6   6D(h^-1 (R^_b R_b^-1) h)
//   linear velocity difference   3
//   angular velocity difference  3   h^-1 (w^_b - w_b), rad/s
//   position                     3
//   rotation                     6   6D(h^-1 R^_b)
//
// The keypoint goal holds no rotation at all, so that it can be given by
// whoever knows points only.
//
// Pure functions; nothing allocates but names. Errors: none.
inline constexpr int kKeypointWidth = 9;
inline constexpr int kBodyGoalWidth = 24;

void WriteKeypointGoal(const BodyState& body, const BodyState& reference,
                       const Eigen::Quaterniond& heading,
                       ObservationWriter& out);
void WriteBodyGoal(const BodyState& body, const BodyState& reference,
                   const Eigen::Quaterniond& heading, ObservationWriter& out);

// Names of those columns, e.g. "keypoint+1/position_difference/left_hand/x" and
// "body+1/rotation/left_hand/00", for the frame `ahead` steps ahead.
void AddKeypointGoalNames(int ahead, const std::vector<std::string>& bodies,
                          std::vector<std::string>* names);
void AddBodyGoalNames(int ahead, const std::vector<std::string>& bodies,
                      std::vector<std::string>* names);

}  // namespace sinew::world

#endif  // SINEW_SIM_WORLD_BODY_GOAL_H_
