#ifndef SINEW_TOOLS_LOCAL_LOCAL_EXPERIENCE_H_
#define SINEW_TOOLS_LOCAL_LOCAL_EXPERIENCE_H_

#include <atomic>
#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/time/time.h"
#include "actor/prepared_snapshot.h"
#include "actor/rollout.h"
#include "actor/rollout_assets.h"
#include "common/mutex.h"
#include "learner/trainer/experience.h"

namespace sinew::tools {

// Experience from threads of this process: orders are run first in, first out
// by as many rollout workers as there are threads. Same bytes as from actors.
//
// Thread-safety: one caller; inside, workers share a queue. Ownership: joins
// its threads. Blocking: Take, until the orders are done, at most `deadline`;
// the destructor, for at most a control step (rollouts are cancelled). Errors:
// a rollout's error comes out of Take and ends the workers.
class LocalExperience final : public learner::Experience {
 public:
  struct Options {
    int threads = 1;                              // >= 1
    int max_environments = 8;                     // per order, >= 1
    absl::Duration deadline = absl::Minutes(10);  // of one Take
  };
  static absl::StatusOr<std::unique_ptr<LocalExperience>> Create(
      const Options& options,
      std::shared_ptr<const actor::RolloutAssets> assets);
  ~LocalExperience() override;

  absl::Status Publish(const learner::PublishedSnapshot& snapshot) override;
  absl::Status Begin(const std::vector<v1::Order>& orders) override;
  absl::StatusOr<std::vector<v1::Segment>> Take(
      const std::vector<int64_t>& order_ids) override;

 private:
  struct Job {
    v1::Order order;
    std::shared_ptr<const actor::PreparedSnapshot> snapshot;
  };

  LocalExperience(const Options& options,
                  std::shared_ptr<const actor::RolloutAssets> assets)
      : options_(options), assets_(std::move(assets)) {}
  void Work(actor::RolloutWorker& worker, const std::stop_token& stop);

  const Options options_;
  const std::shared_ptr<const actor::RolloutAssets> assets_;
  std::vector<std::unique_ptr<actor::RolloutWorker>> workers_;
  std::atomic<bool> cancel_ = false;

  Mutex mu_;
  CondVar work_;
  CondVar done_;
  std::deque<std::shared_ptr<const actor::PreparedSnapshot>> snapshots_
      SINEW_GUARDED_BY(mu_);  // newest last
  std::deque<Job> queue_ SINEW_GUARDED_BY(mu_);
  std::map<int64_t, v1::Segment> segments_ SINEW_GUARDED_BY(mu_);
  absl::Status failure_ SINEW_GUARDED_BY(mu_);

  std::vector<std::jthread> threads_;
};

}  // namespace sinew::tools

#endif  // SINEW_TOOLS_LOCAL_LOCAL_EXPERIENCE_H_
