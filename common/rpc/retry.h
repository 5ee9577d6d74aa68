#ifndef SINEW_COMMON_RPC_RETRY_H_
#define SINEW_COMMON_RPC_RETRY_H_

#include <cstdint>
#include <functional>
#include <random>
#include <stop_token>

#include "absl/status/status.h"
#include "absl/time/time.h"

namespace sinew::rpc {

// How long to wait between attempts: initial, initial * factor, ... up to
// longest, each spread by +-jitter so that peers do not come back in step.
struct BackoffOptions {
  absl::Duration initial = absl::Milliseconds(100);
  absl::Duration longest = absl::Seconds(10);
  double factor = 1.6;
  // Share of the wait, [0, 1).
  double jitter = 0.2;
};

// Another number at every call: hardly ever the same as another caller's, of
// this process or of another one (ids of processes are equal in containers).
// Thread-safe.
uint64_t FreshSeed();

// The waits of one peer. Thread-safety: one thread. Blocking: never.
class Backoff {
 public:
  // Different callers take different seeds (FreshSeed).
  Backoff(const BackoffOptions& options, uint64_t seed);

  // The next wait.
  absl::Duration Next();

  // After a success: the next wait is the initial one again.
  void Reset() { base_ = options_.initial; }

 private:
  const BackoffOptions options_;
  absl::Duration base_;
  std::minstd_rand random_;
};

// Waits; false as soon as `stop` is requested.
bool WaitFor(absl::Duration duration, const std::stop_token& stop);

// Waits for an attempt's turn; false: give up. WaitFor, or a test's own.
using Waiter = std::function<bool(absl::Duration)>;

// Calls `attempt` until it returns OK or an error that is not transient
// (IsTransient), at most `max_attempts` (>= 1) times, waiting in between as
// `backoff` says.
// Returns the last error; CANCELLED, with the last error's text, once `wait`
// says to give up. Only for idempotent calls, each with its own deadline.
absl::Status Retry(Backoff backoff, int max_attempts, const Waiter& wait,
                   const std::function<absl::Status()>& attempt);

}  // namespace sinew::rpc

#endif  // SINEW_COMMON_RPC_RETRY_H_
