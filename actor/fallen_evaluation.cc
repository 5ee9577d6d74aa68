#include "actor/fallen_evaluation.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "absl/strings/str_cat.h"
#include "common/config/recipe.h"
#include "common/status_macros.h"
#include "sim/motion/library.h"
#include "sim/world/get_up_frames.h"

namespace sinew::actor {
namespace {

// Seconds in which the reference stands where the recipe does not say.
constexpr double kStandingSeconds = 3;

absl::Status CheckStates(const world::TrackingTask& task) {
  if (task.num_fallen_states() > 0) return absl::OkStatus();
  return absl::FailedPreconditionError(
      "evaluation from fallen states: expected an asset of role \"fallen\", "
      "found none");
}

// Control steps of a start that has `seconds` to recover.
int32_t StepsOf(const world::TrackingTask& task, double seconds) {
  return static_cast<int32_t>(std::lround(
      (seconds + kHoldSeconds) * task.recipe().physics().control_hz()));
}

// Whether the root stays at `height` or above in frames 0 to `last` of a clip.
bool StaysUpright(const motion::Library& library, int clip, int64_t last,
                  double height) {
  const int64_t end =
      std::min<int64_t>(last + 1, library.clip(clip).num_frames());
  for (int64_t frame = 0; frame < end; ++frame) {
    if (library.frame(clip, frame).root_position[2] < height) return false;
  }
  return true;
}

}  // namespace

absl::StatusOr<std::vector<v1::EvaluationStart>> FallenStarts(
    const world::TrackingTask& task, double seconds) {
  SINEW_RETURN_IF_ERROR(CheckStates(task));
  const double hz = task.recipe().physics().control_hz();
  const int32_t steps = StepsOf(task, seconds);
  const int32_t standing =
      task.recovery().on()
          ? task.recipe().task().recovery().steps()
          : static_cast<int32_t>(std::lround(kStandingSeconds * hz));
  const motion::Library& library = task.library();
  const double height = world::UprightRootHeight(task.character());
  const int last = std::max(1, steps - standing);
  std::vector<int> clips;
  for (int clip = 0; clip < library.num_clips(); ++clip) {
    if (!library.clip(clip).left_out() &&
        motion::LastFrame(library.clip(clip)) + standing >= steps &&
        StaysUpright(library, clip, last, height)) {
      clips.push_back(clip);
    }
  }
  if (clips.empty()) {
    return absl::NotFoundError(absl::StrCat(
        "evaluation from fallen states: expected a clip of at least ",
        steps - standing + 1,
        " frames that is not left out and stays upright, found none"));
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

absl::StatusOr<std::vector<v1::EvaluationStart>> GetUpStarts(
    const world::TrackingTask& task, double seconds) {
  SINEW_RETURN_IF_ERROR(CheckStates(task));
  if (task.num_get_up_frames() == 0) {
    return absl::NotFoundError(
        "evaluation of get-ups: expected a clip that is not left out, begins "
        "on the floor and ends upright, found none");
  }
  const int32_t standing = task.recipe().task().recovery().get_up_steps();
  std::vector<v1::EvaluationStart> starts(task.num_fallen_states());
  for (size_t i = 0; i < starts.size(); ++i) {
    starts[i].set_steps(StepsOf(task, seconds));
    starts[i].set_fallen_state(static_cast<int32_t>(i));
    starts[i].set_recovery_steps(standing > 0 ? standing : kGetUpSteps);
    starts[i].set_get_up(true);
  }
  return starts;
}

world::BodyStart BodyStartOf(const v1::EvaluationStart& start) {
  world::BodyStart body;
  if (!start.has_fallen_state()) return body;
  body.kind = start.get_up() ? v1::START_KIND_GET_UP : v1::START_KIND_FALLEN;
  body.fallen_state = start.fallen_state();
  body.recovery_steps = start.recovery_steps();
  return body;
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
