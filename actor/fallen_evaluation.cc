#include "actor/fallen_evaluation.h"

#include <cmath>
#include <cstdint>

#include "absl/strings/str_cat.h"
#include "sim/motion/library.h"

namespace sinew::actor {
namespace {

// Seconds in which the reference stands where the recipe does not say.
constexpr double kStandingSeconds = 3;

}  // namespace

absl::StatusOr<std::vector<v1::EvaluationStart>> FallenStarts(
    const world::TrackingTask& task, double seconds) {
  if (task.num_fallen_states() == 0) {
    return absl::FailedPreconditionError(
        "evaluation from fallen states: expected an asset of role \"fallen\", "
        "found none");
  }
  const double hz = task.recipe().physics().control_hz();
  const auto steps =
      static_cast<int32_t>(std::lround((seconds + kHoldSeconds) * hz));
  const int32_t standing =
      task.recovery().on()
          ? task.recipe().task().recovery().steps()
          : static_cast<int32_t>(std::lround(kStandingSeconds * hz));
  std::vector<int> clips;
  for (int clip = 0; clip < task.library().num_clips(); ++clip) {
    if (motion::LastFrame(task.library().clip(clip)) + standing >= steps) {
      clips.push_back(clip);
    }
  }
  if (clips.empty()) {
    return absl::FailedPreconditionError(absl::StrCat(
        "evaluation from fallen states: expected a clip of at least ",
        steps - standing + 1, " frames, found none"));
  }
  std::vector<v1::EvaluationStart> starts(task.num_fallen_states());
  for (size_t i = 0; i < starts.size(); ++i) {
    starts[i].set_clip(clips[i % clips.size()]);
    starts[i].set_steps(steps);
    starts[i].set_fallen_state(static_cast<int32_t>(i));
    starts[i].set_recovery_steps(standing);
  }
  return starts;
}

double RecoveredShare(const std::vector<v1::EvaluationResult>& results,
                      double seconds, double control_hz) {
  int fallen = 0, recovered = 0;
  for (const v1::EvaluationResult& result : results) {
    if (!result.has_fallen_state()) continue;
    ++fallen;
    const int frame = result.recovered_at_frame();
    if (frame > 0 && frame <= std::lround(seconds * control_hz)) ++recovered;
  }
  return fallen == 0 ? 0 : static_cast<double>(recovered) / fallen;
}

}  // namespace sinew::actor
