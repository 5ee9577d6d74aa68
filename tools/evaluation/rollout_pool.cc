#include "tools/evaluation/rollout_pool.h"

#include <algorithm>
#include <atomic>
#include <thread>
#include <utility>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "actor/rollout.h"
#include "common/mutex.h"
#include "common/status_macros.h"

namespace sinew::evaluation {
namespace {

// Rows of one forward pass; enough to fill a tile of the matrix kernels.
constexpr size_t kGroupSize = 8;

v1::Order MakeOrder(const actor::RolloutAssets& assets,
                    const actor::PreparedSnapshot& snapshot, int64_t id,
                    absl::Span<const v1::EvaluationStart> starts) {
  v1::Order order;
  order.set_run_id("evaluation");
  order.set_order_id(id);
  order.set_kind(v1::Order::KIND_EVALUATE);
  order.set_snapshot_version(snapshot.version());
  order.set_snapshot_sha256(snapshot.sha256());
  order.set_layout_sha256(assets.layout_sha256());
  order.set_seed(kEvaluationSeed);
  order.set_horizon(1);
  for (const v1::EvaluationStart& start : starts) {
    *order.add_starts() = start;
    order.set_horizon(std::max(order.horizon(), start.steps()));
  }
  return order;
}

// One call of RunStarts: threads take the next group until none is left.
class Pool {
 public:
  Pool(const actor::RolloutAssets& assets,
       const actor::PreparedSnapshot& snapshot,
       absl::Span<const v1::EvaluationStart> starts,
       const FrameObserver& observer)
      : assets_(assets),
        snapshot_(snapshot),
        starts_(starts),
        observer_(observer),
        groups_(GroupStarts(starts)),
        results_(starts.size()) {}

  size_t num_groups() const { return groups_.size(); }
  void Cancel() { cancel_ = true; }

  // The body of one thread.
  void Work(actor::RolloutWorker& worker) {
    for (size_t g = next_++; g < groups_.size() && !cancel_; g = next_++) {
      const absl::Status status = RunGroup(g, worker);
      if (status.ok()) continue;
      MutexLock lock(mu_);
      failure_.Update(status);
      cancel_ = true;
    }
  }

  // After all threads were joined.
  absl::StatusOr<std::vector<v1::EvaluationResult>> Finish() {
    MutexLock lock(mu_);
    if (!failure_.ok()) return failure_;
    return std::move(results_);
  }

 private:
  absl::Status RunGroup(size_t g, actor::RolloutWorker& worker) {
    const StartGroup group = groups_[g];
    if (observer_) {
      worker.SetFrameObserver([this, group](int start, int frame,
                                            const mjData& data,
                                            absl::Span<const float> latent) {
        observer_(group.first + static_cast<size_t>(start), frame, data,
                  latent);
      });
    }
    const v1::Order order =
        MakeOrder(assets_, snapshot_, static_cast<int64_t>(g),
                  starts_.subspan(group.first, group.size));
    SINEW_ASSIGN_OR_RETURN(const v1::Segment segment,
                           worker.Run(order, snapshot_, &cancel_));
    // Every group writes elements of its own.
    for (size_t i = 0; i < group.size; ++i) {
      results_[group.first + i] = segment.results(static_cast<int>(i));
    }
    return absl::OkStatus();
  }

  const actor::RolloutAssets& assets_;
  const actor::PreparedSnapshot& snapshot_;
  const absl::Span<const v1::EvaluationStart> starts_;
  const FrameObserver& observer_;
  const std::vector<StartGroup> groups_;
  std::vector<v1::EvaluationResult> results_;  // by start
  std::atomic<size_t> next_ = 0;
  std::atomic<bool> cancel_ = false;

  Mutex mu_;
  absl::Status failure_ SINEW_GUARDED_BY(mu_);
};

}  // namespace

std::vector<StartGroup> GroupStarts(
    absl::Span<const v1::EvaluationStart> starts) {
  std::vector<StartGroup> groups;
  for (size_t i = 0; i < starts.size(); ++i) {
    if (groups.empty() || groups.back().size == kGroupSize ||
        starts[i].clip() != starts[i - 1].clip()) {
      groups.push_back({.first = i, .size = 0});
    }
    ++groups.back().size;
  }
  return groups;
}

absl::StatusOr<std::vector<v1::EvaluationResult>> RunStarts(
    const std::shared_ptr<const actor::RolloutAssets>& assets,
    const actor::PreparedSnapshot& snapshot,
    absl::Span<const v1::EvaluationStart> starts, int threads,
    const StopToken& stop, const FrameObserver& observer) {
  if (threads < 1) {
    return absl::InvalidArgumentError(
        absl::StrCat("threads: expected >= 1, found ", threads));
  }
  Pool pool(*assets, snapshot, starts, observer);
  const size_t workers =
      std::min(static_cast<size_t>(threads), pool.num_groups());
  std::vector<std::unique_ptr<actor::RolloutWorker>> owned;
  for (size_t i = 0; i < workers; ++i) {
    SINEW_ASSIGN_OR_RETURN(
        auto worker, actor::RolloutWorker::Create(assets, int{kGroupSize}));
    owned.push_back(std::move(worker));
  }
  {
    const std::stop_callback cancel(stop, [&pool] { pool.Cancel(); });
    std::vector<std::jthread> joined;
    for (const auto& worker : owned) {
      joined.emplace_back([&pool, &worker] { pool.Work(*worker); });
    }
  }
  if (stop.stop_requested()) {
    return absl::CancelledError("evaluation: stopped before its end");
  }
  return pool.Finish();
}

}  // namespace sinew::evaluation
