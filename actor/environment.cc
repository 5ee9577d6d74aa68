#include "actor/environment.h"

#include <algorithm>
#include <cmath>

#include "absl/strings/str_cat.h"
#include "common/status_macros.h"

namespace sinew::actor {
namespace {

absl::Status Error(int index, absl::string_view field, int64_t low,
                   int64_t high, int64_t found) {
  return absl::InvalidArgumentError(
      absl::StrCat("order.states[", index, "].", field, ": expected ", low,
                   " to ", high, ", found ", found));
}

absl::Status CheckNumbers(int index, absl::string_view field,
                          const google::protobuf::RepeatedField<double>& found,
                          int expected) {
  if (found.size() != expected) {
    return absl::InvalidArgumentError(
        absl::StrCat("order.states[", index, "].", field, ": expected ",
                     expected, " numbers, found ", found.size()));
  }
  for (int i = 0; i < found.size(); ++i) {
    if (!std::isfinite(found[i])) {
      return absl::InvalidArgumentError(
          absl::StrCat("order.states[", index, "].", field, "[", i,
                       "]: expected a finite number, found ", found[i]));
    }
  }
  return absl::OkStatus();
}

absl::Status CheckRecovery(const v1::EnvironmentState& state, int index,
                           const world::TrackingTask& task) {
  if (!v1::StartKind_IsValid(state.start_kind())) {
    return Error(index, "start_kind", v1::StartKind_MIN, v1::StartKind_MAX,
                 state.start_kind());
  }
  const int64_t steps = task.recovery().on() ? task.recovery().most_steps() : 0;
  const int64_t left = state.recovery_steps_left();
  if (left < 0 || left > steps) {
    return Error(index, "recovery_steps_left", 0, steps, left);
  }
  const int64_t frozen = state.frozen_steps();
  const int64_t most = std::min<int64_t>(steps - left, state.step());
  if (frozen < 0 || frozen > most) {
    return Error(index, "frozen_steps", 0, most, frozen);
  }
  if (!(std::isfinite(state.goal_distance()) && state.goal_distance() >= 0)) {
    return absl::InvalidArgumentError(absl::StrCat(
        "order.states[", index, "].goal_distance: expected >= 0, found ",
        state.goal_distance()));
  }
  return absl::OkStatus();
}

absl::Status CheckEpisode(const v1::EnvironmentState& state, int index,
                          const world::TrackingTask& task) {
  const motion::Library& library = task.library();
  if (state.clip() < 0 || state.clip() >= library.num_clips()) {
    return Error(index, "clip", 0, library.num_clips() - 1, state.clip());
  }
  const v1::ClipInfo& clip = library.clip(state.clip());
  const int64_t last_start = world::NumStartFrames(clip) - 1;
  if (state.start_frame() < 0 || state.start_frame() > last_start) {
    return Error(index, "start_frame", 0, last_start, state.start_frame());
  }
  SINEW_RETURN_IF_ERROR(CheckRecovery(state, index, task));
  const int64_t last_step =
      std::min<int64_t>(task.recipe().task().max_episode_steps(),
                        motion::LastFrame(clip) - state.start_frame()) -
      1 + state.frozen_steps();
  if (state.step() < 0 || state.step() > last_step) {
    return Error(index, "step", 0, last_step, state.step());
  }
  if (!std::isfinite(state.episode_return()) ||
      !std::isfinite(state.episode_error())) {
    return absl::InvalidArgumentError(
        absl::StrCat("order.states[", index,
                     "]: expected finite episode_return and episode_error"));
  }
  return absl::OkStatus();
}

}  // namespace

absl::Status LoadState(const v1::EnvironmentState& state, int index,
                       const world::TrackingTask& task,
                       Environment* environment, absl::Span<double> physics) {
  if (state.episode() < 0) {
    return absl::InvalidArgumentError(
        absl::StrCat("order.states[", index, "].episode: expected >= 0, found ",
                     state.episode()));
  }
  environment->previous_target.resize(task.action_width());
  environment->episode = {};
  environment->episode.episode = state.episode();
  environment->fresh = state.physics().empty();
  if (environment->fresh) return absl::OkStatus();
  SINEW_RETURN_IF_ERROR(
      CheckNumbers(index, "physics", state.physics(), task.state_size()));
  SINEW_RETURN_IF_ERROR(CheckNumbers(
      index, "previous_target", state.previous_target(), task.action_width()));
  SINEW_RETURN_IF_ERROR(CheckEpisode(state, index, task));
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
