#include "actor/fallen_evaluation.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "absl/strings/str_cat.h"
#include "sim/character/character.h"
#include "sim/motion/library.h"

namespace sinew::actor {
namespace {

// Seconds in which the reference stands where the recipe does not say.
constexpr double kStandingSeconds = 3;
// Share of the standing height below which a reference's root lies or crouches:
// to track it would be no standing up.
constexpr double kUprightShare = 0.8;

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
  const motion::Library& library = task.library();
  const double height =
      kUprightShare * task.character().proto().standing_root_height();
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

world::BodyStart BodyStartOf(const v1::EvaluationStart& start) {
  world::BodyStart body;
  if (!start.has_fallen_state()) return body;
  body.kind = v1::START_KIND_FALLEN;
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
