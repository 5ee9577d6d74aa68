#include "common/rpc/retry.h"

#include <algorithm>
#include <atomic>
#include <chrono>

#include "absl/strings/str_cat.h"
#include "common/mutex.h"
#include "common/rpc/status.h"

namespace sinew::rpc {

uint64_t FreshSeed() {
  static std::atomic<uint64_t> next = std::random_device()();
  return next++;
}

Backoff::Backoff(const BackoffOptions& options, uint64_t seed)
    : options_(options), base_(options.initial) {
  random_.seed(static_cast<std::minstd_rand::result_type>(seed));
}

absl::Duration Backoff::Next() {
  const double spread =
      std::uniform_real_distribution<double>(-1, 1)(random_) * options_.jitter;
  const absl::Duration wait = base_ * (1 + spread);
  base_ = std::min(base_ * options_.factor, options_.longest);
  return wait;
}

bool WaitFor(absl::Duration duration, const std::stop_token& stop) {
  const auto deadline =
      std::chrono::steady_clock::now() + absl::ToChronoNanoseconds(duration);
  Mutex mu;
  CondVar never;
  MutexLock lock(mu);
  while (never.WaitUntil(mu, deadline, stop)) {
  }
  return !stop.stop_requested();
}

absl::Status Retry(Backoff backoff, int max_attempts, const Waiter& wait,
                   const std::function<absl::Status()>& attempt) {
  absl::Status status = attempt();
  for (int i = 1; i < max_attempts && IsTransient(status); ++i) {
    if (!wait(backoff.Next())) {
      return absl::CancelledError(
          absl::StrCat("stopped; last error: ", status.message()));
    }
    status = attempt();
  }
  return status;
}

}  // namespace sinew::rpc
