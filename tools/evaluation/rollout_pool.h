#ifndef SINEW_TOOLS_EVALUATION_ROLLOUT_POOL_H_
#define SINEW_TOOLS_EVALUATION_ROLLOUT_POOL_H_

#include <mujoco/mujoco.h>

#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/types/span.h"
#include "actor/prepared_snapshot.h"
#include "actor/rollout_assets.h"
#include "common/stop.h"
#include "proto/sinew/v1/rollout.pb.h"

namespace sinew::evaluation {

// Called after each step, that in which a start fails among them (unless it
// diverged), with data whose bodies and geoms are placed: index of the start in
// the span that was given to RunStarts, and the frame reached, counted from the
// start (>= 1), and the latent of the step that led to it, empty for a policy
// without one. Calls for starts of one group come one after another, in an
// order that does not depend on threads; groups run at the same time.
using FrameObserver =
    std::function<void(size_t start, int frame, const mjData& data,
                       absl::Span<const float> latent)>;

// A group is a run of neighbouring starts of one clip: what one order holds.
struct StartGroup {
  size_t first = 0;
  size_t size = 0;
};

// Seed of the orders, for recipes whose evaluations are randomised.
inline constexpr uint64_t kEvaluationSeed = 0;

// Starts of the same clip in groups of at most 8, in order. Pure.
std::vector<StartGroup> GroupStarts(
    absl::Span<const v1::EvaluationStart> starts);

// Runs a policy from each start, mean action, groups shared out among
// `threads` threads of this process; results in the order of the starts.
// Bit-equal for any number of threads.
//
// Thread-safety: pure, but for the observer. Ownership: joins its threads.
// Blocking: computes until all starts have ended, or for one control step
// after `stop` was requested. Errors: CANCELLED; INVALID_ARGUMENT for threads
// < 1 or starts that do not fit the library; those of RolloutWorker.
absl::StatusOr<std::vector<v1::EvaluationResult>> RunStarts(
    const std::shared_ptr<const actor::RolloutAssets>& assets,
    const actor::PreparedSnapshot& snapshot,
    absl::Span<const v1::EvaluationStart> starts, int threads,
    const StopToken& stop, const FrameObserver& observer = nullptr);

}  // namespace sinew::evaluation

#endif  // SINEW_TOOLS_EVALUATION_ROLLOUT_POOL_H_
