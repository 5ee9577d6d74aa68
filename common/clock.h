#ifndef SINEW_COMMON_CLOCK_H_
#define SINEW_COMMON_CLOCK_H_

#include <chrono>
#include <stop_token>

#include "absl/time/time.h"
#include "common/mutex.h"

namespace sinew {

// Time, injected: SystemClock in programs, testing/simulated_clock.h in tests.
// Two times: wall time is for people and files and may jump; steady time is
// for durations, deadlines and waits.
//
// Thread-safety: yes. Ownership: borrowed by its users, outlives them.
// Blocking: the waits only, as said. Errors: none.
class Clock {
 public:
  using TimePoint = CondVar::TimePoint;

  virtual ~Clock() = default;

  virtual absl::Time WallNow() const = 0;
  virtual TimePoint SteadyNow() const = 0;

  // As CondVar::WaitUntil, with the deadline in this clock's steady time:
  // false once the deadline has passed or stop is requested; may return early.
  // The caller holds `mu` and no other mutex.
  virtual bool WaitUntil(Mutex& mu, CondVar& changed, TimePoint deadline,
                         const std::stop_token& stop) SINEW_REQUIRES(mu) = 0;

  // Waits for `duration`; false as soon as stop is requested.
  bool SleepFor(absl::Duration duration, const std::stop_token& stop);

  // Steady time `duration` from now; infinite durations give a day.
  TimePoint After(absl::Duration duration) const;

  // Seconds since 1970, and steady seconds since an arbitrary moment.
  double WallSeconds() const;
  double SteadySeconds() const;
};

// The machine's clocks.
class SystemClock final : public Clock {
 public:
  absl::Time WallNow() const override;
  TimePoint SteadyNow() const override;
  bool WaitUntil(Mutex& mu, CondVar& changed, TimePoint deadline,
                 const std::stop_token& stop) SINEW_REQUIRES(mu) override;
};

}  // namespace sinew

#endif  // SINEW_COMMON_CLOCK_H_
