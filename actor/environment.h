#ifndef SINEW_ACTOR_ENVIRONMENT_H_
#define SINEW_ACTOR_ENVIRONMENT_H_

#include <cstdint>
#include <vector>

#include "absl/status/status.h"
#include "absl/types/span.h"
#include "proto/sinew/v1/rollout.pb.h"
#include "proto/sinew/v1/state_limits.pb.h"
#include "sim/world/tracking_task.h"

namespace sinew::actor {

// One environment between two control steps: all that its next step depends
// on, but for its physics row, which lies in the worker's batch.
struct Environment {
  int32_t index = 0;  // in the run; keys the random streams
  bool fresh = true;  // no physics: the episode begins at the next step
  world::Episode episode;
  std::vector<double> previous_target;  // [J] rad
  // Of the current episode, drawn again wherever it goes on; unused unless the
  // recipe randomises.
  world::Conditions conditions;
};

// Checks `state` (common/segment/state_limits.h) and loads it; `physics`
// [limits.state_size] is written unless the environment is fresh.
// INVALID_ARGUMENT names "order.states[index]" and the field.
absl::Status LoadState(const v1::EnvironmentState& state, int index,
                       const v1::StateLimits& limits, Environment* environment,
                       absl::Span<double> physics);

// The inverse of LoadState.
void SaveState(const Environment& environment, absl::Span<const double> physics,
               v1::EnvironmentState* state);

// Ends the current episode: the next one begins afresh.
void BeginNextEpisode(Environment* environment);

}  // namespace sinew::actor

#endif  // SINEW_ACTOR_ENVIRONMENT_H_
