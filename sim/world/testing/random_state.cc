#include "sim/world/testing/random_state.h"

#include <cstddef>
#include <random>

namespace sinew::world::testing {

using Eigen::Quaterniond;
using Eigen::Vector3d;

BodyState RandomState(int seed, int bodies, int joints) {
  std::mt19937 generator(seed);
  std::normal_distribution<double> normal;
  const auto vector = [&] {
    return Vector3d(normal(generator), normal(generator), normal(generator));
  };
  BodyState state(bodies, joints);
  for (int b = 0; b < bodies; ++b) {
    state.position[b] = vector();
    state.rotation[b] = Quaterniond(normal(generator), normal(generator),
                                    normal(generator), normal(generator))
                            .normalized();
    state.linear_velocity[b] = vector();
    state.angular_velocity[b] = vector();
  }
  for (int j = 0; j < joints; ++j) {
    state.joint_position[j] = normal(generator);
    state.joint_velocity[j] = normal(generator);
  }
  return state;
}

BodyState Moved(const BodyState& state, double yaw, const Vector3d& offset) {
  const Quaterniond turn(Eigen::AngleAxisd(yaw, Vector3d::UnitZ()));
  BodyState moved = state;
  for (size_t b = 0; b < state.position.size(); ++b) {
    moved.position[b] = turn * state.position[b] + offset;
    moved.rotation[b] = turn * state.rotation[b];
    moved.linear_velocity[b] = turn * state.linear_velocity[b];
    moved.angular_velocity[b] = turn * state.angular_velocity[b];
  }
  return moved;
}

}  // namespace sinew::world::testing
