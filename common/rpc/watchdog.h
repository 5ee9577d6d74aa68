#ifndef SINEW_COMMON_RPC_WATCHDOG_H_
#define SINEW_COMMON_RPC_WATCHDOG_H_

#include <functional>
#include <stop_token>
#include <thread>

#include "absl/time/time.h"
#include "common/mutex.h"

namespace sinew::rpc {

// Calls `expired` once if nobody feeds it for `timeout`: ends streams, which
// have no deadline, when they stand still. gRPC's own keep-alive does not fire
// while a write is blocked.
//
// Thread-safety: any thread feeds. Ownership: owns a thread, joined by the
// destructor; what `expired` touches must live until then. Blocking: the
// destructor, while `expired` runs. Errors: none.
class Watchdog {
 public:
  Watchdog(absl::Duration timeout, std::function<void()> expired);
  ~Watchdog();
  Watchdog(const Watchdog&) = delete;
  Watchdog& operator=(const Watchdog&) = delete;

  // Progress: the time starts again.
  void Feed() SINEW_EXCLUDES(mu_);

  bool has_expired() const SINEW_EXCLUDES(mu_);

 private:
  void Watch(const std::stop_token& stop) SINEW_EXCLUDES(mu_);

  const absl::Duration timeout_;
  const std::function<void()> expired_;
  mutable Mutex mu_;
  CondVar changed_;
  CondVar::TimePoint deadline_ SINEW_GUARDED_BY(mu_);
  bool has_expired_ SINEW_GUARDED_BY(mu_) = false;
  // Last: the thread uses all of the above.
  std::jthread thread_;
};

}  // namespace sinew::rpc

#endif  // SINEW_COMMON_RPC_WATCHDOG_H_
