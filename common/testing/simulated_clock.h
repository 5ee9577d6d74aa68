#ifndef SINEW_COMMON_TESTING_SIMULATED_CLOCK_H_
#define SINEW_COMMON_TESTING_SIMULATED_CLOCK_H_

#include <stop_token>
#include <vector>

#include "absl/time/time.h"
#include "common/clock.h"
#include "common/mutex.h"

namespace sinew::testing {

// A clock that stands still until the test moves it. Threads that wait through
// it wake when their simulated deadline is reached, when they are notified, or
// when stop is requested.
//
//   std::thread waiter([&] { queue.Take(clock.After(absl::Seconds(5))); });
//   clock.AwaitWaiters(1);
//   clock.Advance(absl::Seconds(5));  // Take gives up
//   waiter.join();
//
// Thread-safety: yes. Blocking: Advance, until the waiters have been woken
//   (never call it with a mutex held that a waiter waits on); AwaitWaiters.
// Errors: none.
class SimulatedClock final : public Clock {
 public:
  // Wall time at the start; the steady clock starts at one hour.
  explicit SimulatedClock(absl::Time wall = absl::FromUnixSeconds(1'000'000));

  absl::Time WallNow() const override;
  TimePoint SteadyNow() const override;
  bool WaitUntil(Mutex& mu, CondVar& changed, TimePoint deadline,
                 const std::stop_token& stop) SINEW_REQUIRES(mu) override;

  // Moves both times forward, `duration` >= 0, and wakes all waiters.
  void Advance(absl::Duration duration) SINEW_EXCLUDES(mu_);

  // Waits (in real time, a minute at most) until `count` threads or more wait
  // through this clock; false if that does not happen.
  bool AwaitWaiters(int count) SINEW_EXCLUDES(mu_);

 private:
  struct Waiter {
    Mutex* mu;
    CondVar* changed;
  };

  void Enter(const Waiter& waiter) SINEW_EXCLUDES(mu_);
  void Leave(const Waiter& waiter) SINEW_EXCLUDES(mu_);

  mutable Mutex mu_;
  CondVar changed_;
  absl::Duration elapsed_ SINEW_GUARDED_BY(mu_);
  // True while Advance touches the waiters, which then may not leave.
  bool advancing_ SINEW_GUARDED_BY(mu_) = false;
  std::vector<const Waiter*> waiters_ SINEW_GUARDED_BY(mu_);
  const absl::Time wall_start_;
};

}  // namespace sinew::testing

#endif  // SINEW_COMMON_TESTING_SIMULATED_CLOCK_H_
