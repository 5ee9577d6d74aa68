#include "common/testing/simulated_clock.h"

#include <algorithm>
#include <chrono>
#include <stop_token>
#include <vector>

#include "absl/time/time.h"
#include "common/check.h"
#include "common/clock.h"
#include "common/mutex.h"

namespace sinew::testing {
namespace {

constexpr std::chrono::hours kSteadyStart(1);
constexpr std::chrono::minutes kHangLimit(1);

}  // namespace

SimulatedClock::SimulatedClock(absl::Time wall) : wall_start_(wall) {}

absl::Time SimulatedClock::WallNow() const {
  MutexLock lock(mu_);
  return wall_start_ + elapsed_;
}

Clock::TimePoint SimulatedClock::SteadyNow() const {
  MutexLock lock(mu_);
  return TimePoint(kSteadyStart) + absl::ToChronoNanoseconds(elapsed_);
}

bool SimulatedClock::WaitUntil(Mutex& mu, CondVar& changed, TimePoint deadline,
                               const std::stop_token& stop) {
  // From Enter on, Advance takes `mu` before it notifies: either this thread
  // waits by then, or it entered late enough to see the new time.
  const Waiter waiter = {&mu, &changed};
  Enter(waiter);
  if (SteadyNow() < deadline) changed.Wait(mu, stop);
  // Leave waits for Advance, which may be waiting for `mu`.
  mu.Unlock();
  Leave(waiter);
  mu.Lock();
  return SteadyNow() < deadline && !stop.stop_requested();
}

void SimulatedClock::Enter(const Waiter& waiter) {
  MutexLock lock(mu_);
  waiters_.push_back(&waiter);
  changed_.NotifyAll();
}

void SimulatedClock::Leave(const Waiter& waiter) {
  MutexLock lock(mu_);
  while (advancing_) changed_.Wait(mu_, {});
  waiters_.erase(std::find(waiters_.begin(), waiters_.end(), &waiter));
}

void SimulatedClock::Advance(absl::Duration duration) {
  SINEW_CHECK(duration >= absl::ZeroDuration()) << "time runs forward";
  std::vector<const Waiter*> waiters;
  {
    MutexLock lock(mu_);
    while (advancing_) changed_.Wait(mu_, {});
    elapsed_ += duration;
    advancing_ = true;
    waiters = waiters_;
  }
  for (const Waiter* waiter : waiters) {
    MutexLock lock(*waiter->mu);
    waiter->changed->NotifyAll();
  }
  MutexLock lock(mu_);
  advancing_ = false;
  changed_.NotifyAll();
}

bool SimulatedClock::AwaitWaiters(int count) {
  const auto deadline = std::chrono::steady_clock::now() + kHangLimit;
  MutexLock lock(mu_);
  while (waiters_.size() < static_cast<size_t>(count)) {
    if (!changed_.WaitUntil(mu_, deadline)) break;
  }
  return waiters_.size() >= static_cast<size_t>(count);
}

}  // namespace sinew::testing
