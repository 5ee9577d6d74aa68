#include "sim/world/reward.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "common/math/double4.h"

namespace sinew::world {
namespace {

// Sum over bodies of the squared angle between their two rotations, rad^2.
double SumOfSquaredAngles(const std::vector<Eigen::Quaterniond>& from,
                          const std::vector<Eigen::Quaterniond>& to) {
  double sum = 0;
  for (size_t b = 0; b < from.size(); b += 4) {
    Double4 cosine = Splat4(1);
    Double4 squared_sine = Splat4(0);  // both of half the angle
    for (size_t i = 0; i < std::min<size_t>(4, from.size() - b); ++i) {
      const Eigen::Quaterniond between = from[b + i].conjugate() * to[b + i];
      cosine[i] = std::abs(between.w());
      squared_sine[i] = between.vec().squaredNorm();
    }
    const Double4 angle =
        2 * AngleOf(cosine, __builtin_elementwise_sqrt(squared_sine));
    const Double4 square = angle * angle;
    sum += (square[0] + square[2]) + (square[1] + square[3]);
  }
  return sum;
}

}  // namespace

RewardValue ComputeReward(const v1::Reward& recipe, const BodyState& body,
                          const BodyState& reference, double power) {
  double position = 0, linear = 0, angular = 0;
  const size_t bodies = body.position.size();
  for (size_t b = 0; b < bodies; ++b) {
    position += (reference.position[b] - body.position[b]).squaredNorm();
    linear +=
        (reference.linear_velocity[b] - body.linear_velocity[b]).squaredNorm();
    angular += (reference.angular_velocity[b] - body.angular_velocity[b])
                   .squaredNorm();
  }
  const double rotation = SumOfSquaredAngles(reference.rotation, body.rotation);
  const double per_body = 1.0 / static_cast<double>(bodies);
  const double per_axis = per_body / 3;
  RewardValue value;
  value.terms = {
      std::exp(-recipe.position_kernel() * position * per_axis),
      std::exp(-recipe.rotation_kernel() * rotation * per_body),
      std::exp(-recipe.linear_velocity_kernel() * linear * per_axis),
      std::exp(-recipe.angular_velocity_kernel() * angular * per_axis)};
  value.tracking = recipe.position_weight() * value.terms[0] +
                   recipe.rotation_weight() * value.terms[1] +
                   recipe.linear_velocity_weight() * value.terms[2] +
                   recipe.angular_velocity_weight() * value.terms[3];
  value.total = value.tracking - recipe.power_cost() * power;
  return value;
}

}  // namespace sinew::world
