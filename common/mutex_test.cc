#include "common/mutex.h"

#include <chrono>
#include <deque>
#include <stop_token>
#include <thread>
#include <vector>

#include "gtest/gtest.h"

namespace sinew {
namespace {

using std::chrono::steady_clock;

// Far enough that a test which waits for it fails by its time limit.
steady_clock::time_point Far() {
  return steady_clock::now() + std::chrono::hours(1);
}

class Counter {
 public:
  void Add() {
    MutexLock lock(mu_);
    ++value_;
    changed_.NotifyAll();
  }

  // True if the count reached `value`.
  bool WaitFor(int value, steady_clock::time_point deadline,
               const std::stop_token& stop) {
    MutexLock lock(mu_);
    while (value_ < value) {
      if (!changed_.WaitUntil(mu_, deadline, stop)) break;
    }
    return value_ >= value;
  }

  bool WaitForEver(int value, const std::stop_token& stop) {
    MutexLock lock(mu_);
    while (value_ < value) {
      if (!changed_.Wait(mu_, stop)) break;
    }
    return value_ >= value;
  }

 private:
  Mutex mu_;
  CondVar changed_;
  int value_ SINEW_GUARDED_BY(mu_) = 0;
};

TEST(Mutex, ExcludesOtherThreads) {
  Counter counter;
  std::vector<std::thread> threads;

  for (int t = 0; t < 4; ++t) {
    threads.emplace_back([&counter] {
      for (int i = 0; i < 1000; ++i) counter.Add();
    });
  }
  for (std::thread& thread : threads) thread.join();

  EXPECT_TRUE(counter.WaitFor(4000, steady_clock::now(), {}));
  EXPECT_FALSE(counter.WaitFor(4001, steady_clock::now(), {}));
}

TEST(Mutex, RefusesTryLockWhileHeld) {
  Mutex mu;
  MutexLock lock(mu);
  bool got = true;

  std::thread other([&]() SINEW_NO_THREAD_SAFETY_ANALYSIS {
    got = mu.TryLock();
    if (got) mu.Unlock();
  });
  other.join();

  EXPECT_FALSE(got);
}

TEST(CondVar, WakesOnANotification) {
  Counter counter;

  std::thread adder([&counter] { counter.Add(); });
  const bool reached = counter.WaitFor(1, Far(), {});
  adder.join();

  EXPECT_TRUE(reached);
}

TEST(CondVar, WakesWhenStopIsRequestedBeforeTheDeadline) {
  Counter counter;
  std::stop_source stop;

  std::thread stopper([&stop] { stop.request_stop(); });
  const bool reached = counter.WaitFor(1, Far(), stop.get_token());
  stopper.join();

  EXPECT_FALSE(reached);
}

TEST(CondVar, WakesWhenStopIsRequestedWithoutADeadline) {
  Counter counter;
  std::stop_source stop;

  std::thread stopper([&stop] { stop.request_stop(); });
  const bool reached = counter.WaitForEver(1, stop.get_token());
  stopper.join();

  EXPECT_FALSE(reached);
}

TEST(CondVar, ReturnsAtOnceWhenStopWasRequestedBefore) {
  Counter counter;
  std::stop_source stop;
  stop.request_stop();

  EXPECT_FALSE(counter.WaitForEver(1, stop.get_token()));
}

TEST(CondVar, GivesUpAtTheDeadline) {
  Counter counter;

  EXPECT_FALSE(counter.WaitFor(1, steady_clock::now(), {}));
}

}  // namespace
}  // namespace sinew
