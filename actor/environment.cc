#include "actor/environment.h"

#include <algorithm>

#include "absl/strings/str_cat.h"
#include "common/segment/state_limits.h"

namespace sinew::actor {

absl::Status LoadState(const v1::EnvironmentState& state, int index,
                       const v1::StateLimits& limits, Environment* environment,
                       absl::Span<double> physics) {
  const absl::Status status = CheckState(state, limits);
  if (!status.ok()) {
    return absl::InvalidArgumentError(
        absl::StrCat("order.states[", index, "].", status.message()));
  }
  environment->previous_target.resize(limits.joints());
  environment->episode = {};
  environment->episode.episode = state.episode();
  environment->fresh = state.physics().empty();
  if (environment->fresh) return absl::OkStatus();
  std::copy(state.physics().begin(), state.physics().end(), physics.begin());
  environment->previous_target.assign(state.previous_target().begin(),
                                      state.previous_target().end());
  environment->episode.step = state.step();
  environment->episode.clip = state.clip();
  environment->episode.start_frame = state.start_frame();
  environment->episode.episode_return = state.episode_return();
  environment->episode.episode_error = state.episode_error();
  environment->episode.start_kind = state.start_kind();
  environment->episode.recovery_steps_left = state.recovery_steps_left();
  environment->episode.frozen_steps = state.frozen_steps();
  environment->episode.goal_distance = state.goal_distance();
  return absl::OkStatus();
}

void SaveState(const Environment& environment, absl::Span<const double> physics,
               v1::EnvironmentState* state) {
  state->Clear();
  state->set_episode(environment.episode.episode);
  if (environment.fresh) return;
  state->mutable_physics()->Add(physics.begin(), physics.end());
  state->mutable_previous_target()->Add(environment.previous_target.begin(),
                                        environment.previous_target.end());
  state->set_step(environment.episode.step);
  state->set_clip(environment.episode.clip);
  state->set_start_frame(environment.episode.start_frame);
  state->set_episode_return(environment.episode.episode_return);
  state->set_episode_error(environment.episode.episode_error);
  state->set_start_kind(environment.episode.start_kind);
  state->set_recovery_steps_left(environment.episode.recovery_steps_left);
  state->set_frozen_steps(environment.episode.frozen_steps);
  state->set_goal_distance(environment.episode.goal_distance);
}

void BeginNextEpisode(Environment* environment) {
  const int64_t next = environment->episode.episode + 1;
  environment->episode = {};
  environment->episode.episode = next;
  environment->fresh = true;
}

}  // namespace sinew::actor
