#ifndef SINEW_LEARNER_UPDATE_RANK_POOL_H_
#define SINEW_LEARNER_UPDATE_RANK_POOL_H_

#include <functional>
#include <thread>
#include <vector>

#include "absl/functional/function_ref.h"
#include "absl/status/status.h"
#include "common/mutex.h"

namespace sinew::learner {

// The ranks of a data-parallel update: a fixed number of threads that share
// out numbered tasks. Which rank takes which task is left to chance, so a task
// may depend on its number only; then results do not depend on the number of
// ranks.
//
//   pool.Run(8, [&](int task) { partial[task] = Compute(task); });
//   for (const Partial& p : partial) sum += p;  // in fixed order
//
// Thread-safety: Run has one caller at a time; the destructor waits for no
//   Run. Ownership: owns its threads, which end with it. Blocking: Run, until
//   all tasks are done; ranks are parked between runs. Errors: those of
//   tasks; a task must not throw.
class RankPool {
 public:
  // Starts `ranks` >= 1 threads; each calls `on_start` first (may be empty).
  RankPool(int ranks, std::function<void()> on_start);
  ~RankPool();
  RankPool(const RankPool&) = delete;
  RankPool& operator=(const RankPool&) = delete;

  int ranks() const { return static_cast<int>(threads_.size()); }

  // Calls task(0) ... task(tasks - 1), each once, on the ranks.
  void Run(int tasks, absl::FunctionRef<void(int)> task);
  // The same for tasks that can fail; the first error by number of task.
  absl::Status TryRun(int tasks, absl::FunctionRef<absl::Status(int)> task);

 private:
  void Work(const std::stop_token& stop);
  // Takes the next task, or -1.
  int Next() SINEW_REQUIRES(mu_);

  const std::function<void()> on_start_;

  Mutex mu_;
  CondVar work_;  // tasks were added
  CondVar done_;  // the last task ended
  const absl::FunctionRef<void(int)>* task_ SINEW_GUARDED_BY(mu_) = nullptr;
  int next_ SINEW_GUARDED_BY(mu_) = 0;
  int tasks_ SINEW_GUARDED_BY(mu_) = 0;
  int unfinished_ SINEW_GUARDED_BY(mu_) = 0;

  std::vector<std::jthread> threads_;  // last: ends before what it uses
};

}  // namespace sinew::learner

#endif  // SINEW_LEARNER_UPDATE_RANK_POOL_H_
