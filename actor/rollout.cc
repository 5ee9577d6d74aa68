#include "actor/rollout.h"

#include <algorithm>
#include <utility>

#include "absl/strings/str_cat.h"
#include "actor/order_check.h"
#include "actor/worker_state.h"
#include "common/status_macros.h"

namespace sinew::actor {
namespace {

class Worker final : public RolloutWorker {
 public:
  Worker(std::shared_ptr<const RolloutAssets> assets, PhysicsBatch batch)
      : state_(std::move(assets), std::move(batch)) {}

  absl::StatusOr<v1::Segment> Run(const v1::Order& order,
                                  const PreparedSnapshot& snapshot,
                                  const std::atomic<bool>* cancel) override {
    SINEW_RETURN_IF_ERROR(
        CheckOrder(order, snapshot, *state_.assets, state_.batch.size()));
    SINEW_RETURN_IF_ERROR(state_.policy.SetGraph(snapshot.policy()));
    if (snapshot.teacher() != nullptr) {
      SINEW_RETURN_IF_ERROR(state_.teacher.SetGraph(*snapshot.teacher()));
    }
    if (snapshot.prior() != nullptr) {
      SINEW_RETURN_IF_ERROR(state_.prior.SetGraph(*snapshot.prior()));
    }
    TakeFrames(order, snapshot);
    v1::Segment segment;
    segment.set_run_id(order.run_id());
    segment.set_order_id(order.order_id());
    segment.set_kind(order.kind());
    segment.set_iteration(order.iteration());
    segment.set_snapshot_version(order.snapshot_version());
    segment.set_snapshot_sha256(order.snapshot_sha256());
    segment.set_layout_sha256(order.layout_sha256());
    const auto run =
        order.kind() == v1::Order::KIND_TRAIN ? &RunTraining : &RunEvaluation;
    SINEW_RETURN_IF_ERROR(run(order, snapshot, cancel, state_, &segment));
    return segment;
  }

  void SetFrameObserver(FrameObserver observer) override {
    state_.observer = std::move(observer);
  }

 private:
  // Those that bodies are carried on to by this order.
  void TakeFrames(const v1::Order& order, const PreparedSnapshot& snapshot) {
    const bool trains = order.kind() == v1::Order::KIND_TRAIN;
    if (trains && snapshot.prior() != nullptr) {
      state_.nearest = &state_.assets->nearest_frames();
    }
    const v1::Task& task = state_.task.recipe().task();
    const bool gets_up =
        trains ? task.recovery().get_up_share() > 0
               : std::any_of(order.starts().begin(), order.starts().end(),
                             [](const auto& start) { return start.get_up(); });
    if (gets_up) state_.upright = &state_.assets->upright_frames();
    if (trains && task.start().carry_on_share() > 0) {
      state_.onward = &state_.assets->onward_frames();
    }
  }

  WorkerState state_;
};

}  // namespace

absl::StatusOr<std::unique_ptr<RolloutWorker>> RolloutWorker::Create(
    std::shared_ptr<const RolloutAssets> assets, int max_environments) {
  if (max_environments < 1) {
    return absl::InvalidArgumentError(absl::StrCat(
        "rollout worker: expected at least one environment, found ",
        max_environments));
  }
  SINEW_ASSIGN_OR_RETURN(
      PhysicsBatch batch,
      PhysicsBatch::Create(assets->task().character().model(),
                           max_environments));
  return std::make_unique<Worker>(std::move(assets), std::move(batch));
}

}  // namespace sinew::actor
