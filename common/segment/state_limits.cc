#include "common/segment/state_limits.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <string>

#include "absl/strings/str_cat.h"
#include "absl/strings/string_view.h"
#include "common/segment/segment_layout.h"
#include "common/status_macros.h"

namespace sinew {
namespace {

absl::Status CheckRange(absl::string_view field, int64_t low, int64_t high,
                        int64_t found) {
  if (found >= low && found <= high) return absl::OkStatus();
  return absl::InvalidArgumentError(
      absl::StrCat(field, ": expected ", low, " to ", high, ", found ", found));
}

absl::Status CheckAtLeast(absl::string_view field, int64_t low, int64_t found) {
  if (found >= low) return absl::OkStatus();
  return absl::InvalidArgumentError(
      absl::StrCat(field, ": expected >= ", low, ", found ", found));
}

absl::Status CheckNumbers(absl::string_view field,
                          const google::protobuf::RepeatedField<double>& found,
                          int expected) {
  if (found.size() != expected) {
    return absl::InvalidArgumentError(absl::StrCat(
        field, ": expected ", expected, " numbers, found ", found.size()));
  }
  for (int i = 0; i < found.size(); ++i) {
    if (!std::isfinite(found[i])) {
      return absl::InvalidArgumentError(absl::StrCat(
          field, "[", i, "]: expected a finite number, found ", found[i]));
    }
  }
  return absl::OkStatus();
}

absl::Status CheckRecovery(const v1::EnvironmentState& state,
                           const v1::StateLimits& limits) {
  SINEW_RETURN_IF_ERROR(CheckRange("start_kind", v1::StartKind_MIN,
                                   v1::StartKind_MAX, state.start_kind()));
  const int64_t steps = limits.recovery_steps();
  const int64_t left = state.recovery_steps_left();
  SINEW_RETURN_IF_ERROR(CheckRange("recovery_steps_left", 0, steps, left));
  SINEW_RETURN_IF_ERROR(CheckRange(
      "frozen_steps", 0, std::min<int64_t>(steps - left, state.step()),
      state.frozen_steps()));
  if (!(std::isfinite(state.goal_distance()) && state.goal_distance() >= 0)) {
    return absl::InvalidArgumentError(absl::StrCat(
        "goal_distance: expected >= 0, found ", state.goal_distance()));
  }
  return absl::OkStatus();
}

// Steps after which an episode that began there is over, those apart in which
// its reference stands.
int64_t MostSteps(int32_t clip, int32_t start_frame,
                  const v1::StateLimits& limits) {
  const int64_t most = limits.max_episode_steps();
  const v1::StateLimits::Clip& limit = limits.clips(clip);
  if (limit.loops()) return most;
  return std::min<int64_t>(most, limit.start_frames() - start_frame);
}

// Column "clip" of a training segment.
absl::Status CheckRowClips(const v1::Segment& segment,
                           const v1::StateLimits& limits) {
  const v1::Tensor* column = FindColumn(segment, column::kClip);
  if (column == nullptr || column->dtype() != v1::DATA_TYPE_INT32) {
    return absl::OkStatus();
  }
  const std::string& data = column->data();
  for (size_t i = 0; i + sizeof(int32_t) <= data.size(); i += sizeof(int32_t)) {
    int32_t clip;
    std::memcpy(&clip, data.data() + i, sizeof(clip));
    if (clip >= 0 && clip < limits.clips_size()) continue;
    return CheckRange(
        absl::StrCat("segment column clip[", i / sizeof(clip), "]"), 0,
        limits.clips_size() - 1, clip);
  }
  return absl::OkStatus();
}

// Of an item of a list, what is said of it with the list's name before it.
absl::Status OfItem(absl::string_view list, int index,
                    const absl::Status& status) {
  if (status.ok()) return status;
  return absl::InvalidArgumentError(
      absl::StrCat(list, "[", index, "].", status.message()));
}

}  // namespace

absl::Status CheckLimits(const v1::StateLimits& limits) {
  SINEW_RETURN_IF_ERROR(CheckAtLeast("limits.clips", 1, limits.clips_size()));
  for (int i = 0; i < limits.clips_size(); ++i) {
    const int32_t frames = limits.clips(i).start_frames();
    if (frames >= 1) continue;
    return CheckAtLeast(absl::StrCat("limits.clips[", i, "].start_frames"), 1,
                        frames);
  }
  SINEW_RETURN_IF_ERROR(
      CheckAtLeast("limits.state_size", 1, limits.state_size()));
  SINEW_RETURN_IF_ERROR(CheckAtLeast("limits.joints", 1, limits.joints()));
  SINEW_RETURN_IF_ERROR(
      CheckAtLeast("limits.max_episode_steps", 1, limits.max_episode_steps()));
  return CheckAtLeast("limits.recovery_steps", 0, limits.recovery_steps());
}

absl::Status CheckPlace(int32_t clip, int32_t start_frame,
                        const v1::StateLimits& limits) {
  SINEW_RETURN_IF_ERROR(CheckRange("clip", 0, limits.clips_size() - 1, clip));
  const int64_t frames = limits.clips(clip).start_frames();
  return CheckRange("start_frame", 0, frames - 1, start_frame);
}

absl::Status CheckEpisode(const v1::EpisodeEnd& episode,
                          const v1::StateLimits& limits) {
  SINEW_RETURN_IF_ERROR(
      CheckPlace(episode.clip(), episode.start_frame(), limits));
  const int64_t most =
      MostSteps(episode.clip(), episode.start_frame(), limits) +
      limits.recovery_steps();
  return CheckRange("steps", 1, most, episode.steps());
}

absl::Status CheckState(const v1::EnvironmentState& state,
                        const v1::StateLimits& limits) {
  SINEW_RETURN_IF_ERROR(CheckAtLeast("episode", 0, state.episode()));
  if (state.physics().empty()) return absl::OkStatus();
  SINEW_RETURN_IF_ERROR(
      CheckNumbers("physics", state.physics(), limits.state_size()));
  SINEW_RETURN_IF_ERROR(CheckNumbers("previous_target", state.previous_target(),
                                     limits.joints()));
  SINEW_RETURN_IF_ERROR(CheckPlace(state.clip(), state.start_frame(), limits));
  SINEW_RETURN_IF_ERROR(CheckAtLeast("step", 0, state.step()));
  SINEW_RETURN_IF_ERROR(CheckRecovery(state, limits));
  const int64_t most = MostSteps(state.clip(), state.start_frame(), limits);
  SINEW_RETURN_IF_ERROR(
      CheckRange("step", 0, most - 1 + state.frozen_steps(), state.step()));
  if (!std::isfinite(state.episode_return()) ||
      !std::isfinite(state.episode_error())) {
    return absl::InvalidArgumentError(absl::StrCat(
        "episode_return and episode_error: expected finite numbers, found ",
        state.episode_return(), " and ", state.episode_error()));
  }
  return absl::OkStatus();
}

absl::Status CheckSegment(const v1::Segment& segment,
                          const v1::StateLimits& limits) {
  SINEW_RETURN_IF_ERROR(CheckRowClips(segment, limits));
  for (int i = 0; i < segment.end_states_size(); ++i) {
    SINEW_RETURN_IF_ERROR(
        OfItem("end_states", i, CheckState(segment.end_states(i), limits)));
  }
  for (int i = 0; i < segment.episodes_size(); ++i) {
    SINEW_RETURN_IF_ERROR(
        OfItem("episodes", i, CheckEpisode(segment.episodes(i), limits)));
  }
  for (int i = 0; i < segment.results_size(); ++i) {
    const v1::EvaluationResult& result = segment.results(i);
    absl::Status status =
        CheckPlace(result.clip(), result.start_frame(), limits);
    for (int j = 0; status.ok() && j < result.carried_size(); ++j) {
      const auto& to = result.carried(j);
      status =
          OfItem("carried", j, CheckPlace(to.clip(), to.start_frame(), limits));
    }
    SINEW_RETURN_IF_ERROR(OfItem("results", i, status));
  }
  return absl::OkStatus();
}

}  // namespace sinew
