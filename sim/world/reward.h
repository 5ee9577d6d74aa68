#ifndef SINEW_SIM_WORLD_REWARD_H_
#define SINEW_SIM_WORLD_REWARD_H_

#include <array>

#include "proto/sinew/v1/recipe.pb.h"
#include "sim/world/body_state.h"

namespace sinew::world {

// Reward of one step: its kernels before weighting, and sums.
struct RewardValue {
  // Position, rotation, linear velocity, angular velocity; each in (0, 1].
  std::array<double, 4> terms = {0, 0, 0, 0};
  double tracking = 0;  // weighted sum of the terms
  double total = 0;     // tracking less the cost of power
};

// The four-term tracking reward of PHC (Luo et al. 2023), on B tracked bodies
// in the world frame, hats for the reference:
//
//   e_p = mean over bodies and x, y, z of (p^ - p)^2             m^2
//   e_r = mean over bodies of angle(R^ R^-1)^2, angle in [0, pi] rad^2
//   e_v = mean over bodies and x, y, z of (v^ - v)^2             (m/s)^2
//   e_w = mean over bodies and x, y, z of (w^ - w)^2             (rad/s)^2
//   reward = sum_i weight_i exp(-kernel_i e_i) - power_cost * power
//
// The means are over the three axes too: an error of 100 mm on every axis of
// every body gives exp(-1) with kernel 100. v is the velocity of body frame
// origins. power is in watts (actuation.h).
//
// Pure function; does not allocate. Non-finite in gives non-finite out.
RewardValue ComputeReward(const v1::Reward& recipe, const BodyState& body,
                          const BodyState& reference, double power);

}  // namespace sinew::world

#endif  // SINEW_SIM_WORLD_REWARD_H_
