#ifndef SINEW_SIM_WORLD_EPISODE_H_
#define SINEW_SIM_WORLD_EPISODE_H_

#include <cstdint>

#include "proto/sinew/v1/rollout.pb.h"

namespace sinew::world {

// One environment's episode, between steps: plain data, mirrors
// v1::EnvironmentState without physics row and previous target.
struct Episode {
  int64_t episode = 0;
  int32_t step = 0;
  int32_t clip = 0;
  int32_t start_frame = 0;
  double episode_return = 0;
  double episode_error = 0;  // sum of mean body distances, m
  v1::StartKind start_kind = v1::START_KIND_REFERENCE;
  int32_t recovery_steps_left = 0;
  int32_t frozen_steps = 0;
  double goal_distance = 0;  // between the roots, m
};

// Frame of the clip that is current at the episode's state.
inline int64_t CurrentFrame(const Episode& episode) {
  return int64_t{episode.start_frame} + episode.step - episode.frozen_steps;
}

}  // namespace sinew::world

#endif  // SINEW_SIM_WORLD_EPISODE_H_
