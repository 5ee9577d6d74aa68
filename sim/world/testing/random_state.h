#ifndef SINEW_SIM_WORLD_TESTING_RANDOM_STATE_H_
#define SINEW_SIM_WORLD_TESTING_RANDOM_STATE_H_

#include <Eigen/Geometry>

#include "sim/world/body_state.h"

namespace sinew::world::testing {

// A state whose numbers are standard normal, a function of the arguments.
BodyState RandomState(int seed, int bodies, int joints);

// The state seen from a world that is turned about its z and moved.
BodyState Moved(const BodyState& state, double yaw,
                const Eigen::Vector3d& offset);

}  // namespace sinew::world::testing

#endif  // SINEW_SIM_WORLD_TESTING_RANDOM_STATE_H_
