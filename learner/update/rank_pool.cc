#include "learner/update/rank_pool.h"

#include <utility>

#include "common/check.h"

namespace sinew::learner {

RankPool::RankPool(int ranks, std::function<void()> on_start)
    : on_start_(std::move(on_start)) {
  SINEW_CHECK(ranks >= 1) << "ranks " << ranks;
  threads_.reserve(ranks);
  for (int rank = 0; rank < ranks; ++rank) {
    threads_.emplace_back([this](const std::stop_token& stop) { Work(stop); });
  }
}

RankPool::~RankPool() {
  for (std::jthread& thread : threads_) thread.request_stop();
}

void RankPool::Run(int tasks, absl::FunctionRef<void(int)> task) {
  if (tasks <= 0) return;
  MutexLock lock(mu_);
  SINEW_CHECK(unfinished_ == 0) << "Run has one caller at a time";
  task_ = &task;
  next_ = 0;
  tasks_ = unfinished_ = tasks;
  work_.NotifyAll();
  // Bounded by the tasks themselves: ranks end only with the pool.
  while (unfinished_ > 0) done_.Wait(mu_, std::stop_token());
  task_ = nullptr;
}

absl::Status RankPool::TryRun(int tasks,
                              absl::FunctionRef<absl::Status(int)> task) {
  std::vector<absl::Status> statuses(tasks);
  Run(tasks, [&](int number) { statuses[number] = task(number); });
  for (absl::Status& status : statuses) {
    if (!status.ok()) return std::move(status);
  }
  return absl::OkStatus();
}

int RankPool::Next() { return next_ < tasks_ ? next_++ : -1; }

void RankPool::Work(const std::stop_token& stop) {
  if (on_start_) on_start_();
  mu_.Lock();
  while (!stop.stop_requested()) {
    const int number = Next();
    if (number < 0) {
      work_.Wait(mu_, stop);
      continue;
    }
    const absl::FunctionRef<void(int)> task = *task_;
    mu_.Unlock();
    task(number);
    mu_.Lock();
    if (--unfinished_ == 0) done_.NotifyOne();
  }
  mu_.Unlock();
}

}  // namespace sinew::learner
