#include "tools/local/local_experience.h"

#include <algorithm>
#include <chrono>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/time/clock.h"
#include "common/status_macros.h"

namespace sinew::tools {
namespace {

// Snapshots that orders may name: the newest and those still in flight.
constexpr size_t kKeptSnapshots = 3;

}  // namespace

absl::StatusOr<std::unique_ptr<LocalExperience>> LocalExperience::Create(
    const Options& options,
    std::shared_ptr<const actor::RolloutAssets> assets) {
  if (options.threads < 1) {
    return absl::InvalidArgumentError(
        absl::StrCat("threads: expected >= 1, found ", options.threads));
  }
  auto result = std::unique_ptr<LocalExperience>(
      new LocalExperience(options, std::move(assets)));
  for (int i = 0; i < options.threads; ++i) {
    SINEW_ASSIGN_OR_RETURN(auto worker,
                           actor::RolloutWorker::Create(
                               result->assets_, options.max_environments));
    result->workers_.push_back(std::move(worker));
  }
  for (auto& worker : result->workers_) {
    result->threads_.emplace_back(
        [self = result.get(), worker = worker.get()](std::stop_token stop) {
          self->Work(*worker, stop);
        });
  }
  return result;
}

LocalExperience::~LocalExperience() {
  cancel_ = true;
  for (std::jthread& thread : threads_) thread.request_stop();
}

absl::Status LocalExperience::Publish(
    const learner::PublishedSnapshot& snapshot) {
  SINEW_ASSIGN_OR_RETURN(
      auto prepared, actor::PreparedSnapshot::Create(
                         snapshot.snapshot, snapshot.sha256, *assets_));
  MutexLock lock(mu_);
  snapshots_.push_back(std::move(prepared));
  if (snapshots_.size() > kKeptSnapshots) snapshots_.pop_front();
  return absl::OkStatus();
}

absl::Status LocalExperience::Begin(const std::vector<v1::Order>& orders) {
  MutexLock lock(mu_);
  for (const v1::Order& order : orders) {
    const auto it = std::find_if(
        snapshots_.begin(), snapshots_.end(), [&](const auto& snapshot) {
          return snapshot->sha256() == order.snapshot_sha256();
        });
    if (it == snapshots_.end()) {
      return absl::NotFoundError(absl::StrCat(
          "order ", order.order_id(), ": snapshot ", order.snapshot_version(),
          " (", order.snapshot_sha256(), ") was not published"));
    }
    queue_.push_back({order, *it});
  }
  work_.NotifyAll();
  return absl::OkStatus();
}

void LocalExperience::Work(actor::RolloutWorker& worker,
                           const std::stop_token& stop) {
  while (!stop.stop_requested()) {
    Job job;
    {
      MutexLock lock(mu_);
      while (queue_.empty()) {
        if (!work_.Wait(mu_, stop)) return;
      }
      job = std::move(queue_.front());
      queue_.pop_front();
    }
    absl::StatusOr<v1::Segment> segment =
        worker.Run(job.order, *job.snapshot, &cancel_);
    MutexLock lock(mu_);
    if (segment.ok()) {
      segments_[job.order.order_id()] = *std::move(segment);
    } else {
      failure_.Update(segment.status());
    }
    done_.NotifyAll();
  }
}

absl::StatusOr<std::vector<v1::Segment>> LocalExperience::Take(
    const std::vector<int64_t>& order_ids) {
  const auto deadline = std::chrono::steady_clock::now() +
                        absl::ToChronoNanoseconds(options_.deadline);
  MutexLock lock(mu_);
  for (int64_t id : order_ids) {
    while (!segments_.contains(id)) {
      if (!failure_.ok()) return failure_;
      if (!done_.WaitUntil(mu_, deadline)) {
        return absl::DeadlineExceededError(absl::StrCat(
            "order ", id, ": no segment after ",
            absl::FormatDuration(options_.deadline)));
      }
    }
  }
  std::vector<v1::Segment> result;
  for (int64_t id : order_ids) {
    result.push_back(std::move(segments_.extract(id).mapped()));
  }
  return result;
}

}  // namespace sinew::tools
