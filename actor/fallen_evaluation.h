#ifndef SINEW_ACTOR_FALLEN_EVALUATION_H_
#define SINEW_ACTOR_FALLEN_EVALUATION_H_

#include <vector>

#include "absl/status/statusor.h"
#include "proto/sinew/v1/rollout.pb.h"
#include "sim/world/tracking_task.h"

namespace sinew::actor {

// Evaluation from the floor: what share of fallen bodies stands and tracks
// again in time.
//
//   starts = FallenStarts(task, 5);             // into KIND_EVALUATE orders
//                                               // (or GetUpStarts)
//   share3 = RecoveredShare(results, 3, 30);    // of all their results
//   share5 = RecoveredShare(results, 5, 30);
//
// Pure functions. Errors: as stated.

// A body that is up by the last of `seconds` has to stay up for this long.
inline constexpr double kHoldSeconds = 0.5;

// One start for each fallen state i of the task, in order: frame 0 of the clips
// that are long enough for `seconds` and kHoldSeconds beside the steps in which
// the reference stands (the recipe's, or 3 s where it has no recovery), are not
// left out, and whose root stays upright (world::UprightRootHeight) over
// the frames used: who lies beside a reference that lies has not recovered. One
// after the other. FAILED_PRECONDITION: no fallen states; NOT_FOUND: no such
// clip.
absl::StatusOr<std::vector<v1::EvaluationStart>> FallenStarts(
    const world::TrackingTask& task, double seconds);

// The same with a get-up (sim/world/get_up_frames.h) for a reference, whichever
// is nearest to the body: it stands for the recipe's get_up_steps, or
// kGetUpSteps where the recipe has none, and when it is over the body goes on
// at the library's nearest frame that stays up. FAILED_PRECONDITION: no fallen
// states; NOT_FOUND: no get-up.
absl::StatusOr<std::vector<v1::EvaluationStart>> GetUpStarts(
    const world::TrackingTask& task, double seconds);

// How the body begins such a start; on the reference where it names no fallen
// state.
world::BodyStart BodyStartOf(const v1::EvaluationStart& start);

// Share of the results that name a fallen state whose body stood and tracked
// from within `seconds` on to their end, [0, 1]; 0 if there are none.
double RecoveredShare(const std::vector<v1::EvaluationResult>& results,
                      double seconds, double control_hz);

}  // namespace sinew::actor

#endif  // SINEW_ACTOR_FALLEN_EVALUATION_H_
