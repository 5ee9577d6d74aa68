#ifndef SINEW_ACTOR_ENVIRONMENT_H_
#define SINEW_ACTOR_ENVIRONMENT_H_

#include <cstdint>
#include <vector>

#include "absl/status/status.h"
#include "proto/sinew/v1/rollout.pb.h"
#include "sim/world/tracking_task.h"

namespace sinew::actor {

// One environment between two control steps: all that its next step depends
// on, in the form in which a rollout works on it.
struct Environment {
  int32_t index = 0;  // in the run; keys the random streams
  bool fresh = true;  // no physics: the episode begins at the next step
  world::Episode episode;
  std::vector<double> physics;          // [state_size] mjSTATE_INTEGRATION
  std::vector<double> previous_target;  // [J] rad
};

// Checks that `state` fits `task` (sizes, finiteness, ranges) and loads it.
// INVALID_ARGUMENT names "order.states[index]" and the field. Allocates only if
// `environment` was never used with the task.
absl::Status LoadState(const v1::EnvironmentState& state, int index,
                       const world::TrackingTask& task,
                       Environment* environment);

// The inverse of LoadState.
void SaveState(const Environment& environment, v1::EnvironmentState* state);

// Ends the current episode: the next one begins afresh.
void BeginNextEpisode(Environment* environment);

}  // namespace sinew::actor

#endif  // SINEW_ACTOR_ENVIRONMENT_H_
