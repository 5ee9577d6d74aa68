#include "sim/world/reward.h"

#include <cmath>

#include "sim/motion/rotation.h"

namespace sinew::world {

RewardValue ComputeReward(const v1::Reward& recipe, const BodyState& body,
                          const BodyState& reference, double power) {
  double position = 0, rotation = 0, linear = 0, angular = 0;
  const size_t bodies = body.position.size();
  for (size_t b = 0; b < bodies; ++b) {
    const double angle =
        motion::AngleBetween(reference.rotation[b], body.rotation[b]);
    position += (reference.position[b] - body.position[b]).squaredNorm();
    rotation += angle * angle;
    linear +=
        (reference.linear_velocity[b] - body.linear_velocity[b]).squaredNorm();
    angular += (reference.angular_velocity[b] - body.angular_velocity[b])
                   .squaredNorm();
  }
  const double per_body = 1.0 / static_cast<double>(bodies);
  const double per_axis = per_body / 3;
  RewardValue value;
  value.terms = {
      std::exp(-recipe.position_kernel() * position * per_axis),
      std::exp(-recipe.rotation_kernel() * rotation * per_body),
      std::exp(-recipe.linear_velocity_kernel() * linear * per_axis),
      std::exp(-recipe.angular_velocity_kernel() * angular * per_axis)};
  value.total = recipe.position_weight() * value.terms[0] +
                recipe.rotation_weight() * value.terms[1] +
                recipe.linear_velocity_weight() * value.terms[2] +
                recipe.angular_velocity_weight() * value.terms[3] -
                recipe.power_cost() * power;
  return value;
}

}  // namespace sinew::world
