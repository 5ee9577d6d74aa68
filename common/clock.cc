#include "common/clock.h"

#include <algorithm>
#include <chrono>
#include <stop_token>

#include "absl/time/clock.h"
#include "absl/time/time.h"
#include "common/mutex.h"

namespace sinew {
namespace {

// Every wait ends: a deadline that somebody left infinite is cut to this.
constexpr absl::Duration kLongestWait = absl::Hours(24);

}  // namespace

bool Clock::SleepFor(absl::Duration duration, const std::stop_token& stop) {
  Mutex mu;
  CondVar never_notified;
  const TimePoint deadline = After(duration);
  MutexLock lock(mu);
  while (WaitUntil(mu, never_notified, deadline, stop)) {
  }
  return !stop.stop_requested();
}

Clock::TimePoint Clock::After(absl::Duration duration) const {
  return SteadyNow() + absl::ToChronoNanoseconds(
                           std::clamp(duration, -kLongestWait, kLongestWait));
}

double Clock::WallSeconds() const {
  return absl::ToDoubleSeconds(WallNow() - absl::UnixEpoch());
}

double Clock::SteadySeconds() const {
  return std::chrono::duration<double>(SteadyNow().time_since_epoch()).count();
}

absl::Time SystemClock::WallNow() const { return absl::Now(); }

Clock::TimePoint SystemClock::SteadyNow() const {
  return std::chrono::steady_clock::now();
}

bool SystemClock::WaitUntil(Mutex& mu, CondVar& changed, TimePoint deadline,
                            const std::stop_token& stop) {
  return changed.WaitUntil(mu, deadline, stop);
}

}  // namespace sinew
