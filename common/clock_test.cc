#include "common/clock.h"

#include <atomic>
#include <chrono>
#include <stop_token>
#include <thread>
#include <vector>

#include "absl/time/time.h"
#include "common/mutex.h"
#include "common/testing/simulated_clock.h"
#include "gtest/gtest.h"

namespace sinew {
namespace {

using ::sinew::testing::SimulatedClock;

// One flag behind a mutex, waited for through a clock.
class Gate {
 public:
  explicit Gate(Clock& clock) : clock_(clock) {}

  void Open() {
    MutexLock lock(mu_);
    open_ = true;
    changed_.NotifyAll();
  }

  bool Await(absl::Duration timeout, const std::stop_token& stop = {}) {
    const Clock::TimePoint deadline = clock_.After(timeout);
    MutexLock lock(mu_);
    while (!open_) {
      if (!clock_.WaitUntil(mu_, changed_, deadline, stop)) break;
    }
    return open_;
  }

 private:
  Clock& clock_;
  Mutex mu_;
  CondVar changed_;
  bool open_ SINEW_GUARDED_BY(mu_) = false;
};

TEST(SystemClock, NeverRunsBackwards) {
  const SystemClock clock;

  const Clock::TimePoint before = clock.SteadyNow();

  EXPECT_GE(clock.SteadyNow(), before);
  EXPECT_GT(clock.WallNow(), absl::FromUnixSeconds(1'600'000'000));
}

TEST(SystemClock, GivesUpAtADeadlineInThePast) {
  SystemClock clock;
  Gate gate(clock);

  EXPECT_FALSE(gate.Await(absl::Seconds(-1)));
}

TEST(SystemClock, CutsInfiniteWaitsToADay) {
  const SystemClock clock;

  EXPECT_LE(clock.After(absl::InfiniteDuration()),
            clock.SteadyNow() + std::chrono::hours(25));
}

TEST(SystemClock, SleepsUntilStopIsRequested) {
  SystemClock clock;
  std::stop_source stop;

  std::thread stopper([&stop] { stop.request_stop(); });
  const bool slept = clock.SleepFor(absl::Hours(1), stop.get_token());
  stopper.join();

  EXPECT_FALSE(slept);
}

TEST(SimulatedClock, StandsStillUntilAdvanced) {
  SimulatedClock clock(absl::FromUnixSeconds(100));
  const double steady = clock.SteadySeconds();

  EXPECT_EQ(clock.WallSeconds(), 100);
  clock.Advance(absl::Milliseconds(2500));

  EXPECT_EQ(clock.WallSeconds(), 102.5);
  EXPECT_EQ(clock.SteadySeconds(), steady + 2.5);
}

TEST(SimulatedClock, WakesAWaiterAtItsDeadlineAndNotBefore) {
  SimulatedClock clock;
  Gate gate(clock);
  std::atomic<bool> done = false;
  std::thread waiter([&] {
    EXPECT_FALSE(gate.Await(absl::Seconds(5)));
    done = true;
  });

  ASSERT_TRUE(clock.AwaitWaiters(1));
  clock.Advance(absl::Seconds(4));
  ASSERT_TRUE(clock.AwaitWaiters(1));
  EXPECT_FALSE(done);
  clock.Advance(absl::Seconds(1));
  waiter.join();

  EXPECT_TRUE(done);
}

TEST(SimulatedClock, WakesAWaiterThatIsNotified) {
  SimulatedClock clock;
  Gate gate(clock);
  std::thread waiter([&] { EXPECT_TRUE(gate.Await(absl::Seconds(5))); });

  ASSERT_TRUE(clock.AwaitWaiters(1));
  gate.Open();

  waiter.join();
}

TEST(SimulatedClock, WakesAWaiterThatIsToStop) {
  SimulatedClock clock;
  std::stop_source stop;
  std::thread waiter([&] {
    EXPECT_FALSE(clock.SleepFor(absl::Seconds(5), stop.get_token()));
  });

  ASSERT_TRUE(clock.AwaitWaiters(1));
  stop.request_stop();

  waiter.join();
}

TEST(SimulatedClock, WakesManyWaitersWhileManyAdvance) {
  SimulatedClock clock;
  std::vector<std::thread> threads;
  for (int i = 1; i <= 4; ++i) {
    threads.emplace_back([&clock, i] {
      EXPECT_TRUE(clock.SleepFor(absl::Seconds(10 * i), {}));
    });
  }
  ASSERT_TRUE(clock.AwaitWaiters(4));

  for (int i = 0; i < 2; ++i) {
    threads.emplace_back([&clock] {
      for (int step = 0; step < 20; ++step) clock.Advance(absl::Seconds(1));
    });
  }

  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(clock.WallNow(), absl::FromUnixSeconds(1'000'040));
}

}  // namespace
}  // namespace sinew
