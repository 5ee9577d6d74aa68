#include "actor/worker_state.h"

#include <cmath>
#include <utility>

#include "absl/strings/str_cat.h"

namespace sinew::actor {
namespace {

bool AllFinite(absl::Span<const float> values) {
  for (float value : values) {
    if (!std::isfinite(value)) return false;
  }
  return true;
}

}  // namespace

WorkerState::WorkerState(std::shared_ptr<const RolloutAssets> shared_assets,
                         PhysicsBatch physics_batch)
    : assets(std::move(shared_assets)),
      task(assets->task()),
      batch(std::move(physics_batch)),
      work(task.MakeWorkspace()),
      policy(batch.size()),
      teacher(batch.size()),
      prior(batch.size()),
      environments(batch.size()),
      acting(batch.size()),
      target(task.action_width(), 0.0),
      base(target),
      teacher_base(target),
      noisy_action(target.size()) {
  for (Environment& environment : environments) {
    environment.conditions = task.MakeConditions();
  }
}

absl::Status CheckCancelled(const std::atomic<bool>* cancel,
                            const v1::Order& order) {
  if (cancel == nullptr || !cancel->load(std::memory_order_relaxed)) {
    return absl::OkStatus();
  }
  return absl::CancelledError(
      absl::StrCat("order ", order.order_id(), " was cancelled"));
}

absl::Status CheckPolicyOutput(const PolicyRunner& policy, int row,
                               double log_probability,
                               const PreparedSnapshot& snapshot) {
  if (AllFinite(policy.action(row)) && AllFinite(policy.mean(row)) &&
      std::isfinite(static_cast<float>(log_probability))) {
    return absl::OkStatus();
  }
  return absl::FailedPreconditionError(
      absl::StrCat("snapshot version ", snapshot.version(),
                   ": expected finite actions, the policy gave others"));
}

}  // namespace sinew::actor
