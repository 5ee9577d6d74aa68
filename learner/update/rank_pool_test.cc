#include "learner/update/rank_pool.h"

#include <atomic>
#include <latch>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace sinew::learner {
namespace {

using ::testing::Each;

TEST(RankPool, RunsEveryTaskOnce) {
  for (int ranks : {1, 2, 3}) {
    RankPool pool(ranks, nullptr);
    for (int tasks : {0, 1, 2, 17}) {
      std::vector<int> calls(tasks);

      pool.Run(tasks, [&](int task) { ++calls[task]; });

      EXPECT_THAT(calls, Each(1)) << ranks << " ranks, " << tasks << " tasks";
    }
  }
}

TEST(RankPool, WritesOfTasksAreSeenByTheCaller) {
  RankPool pool(2, nullptr);
  std::vector<int> partial(8);
  int total = 0;
  for (int round = 0; round < 200; ++round) {
    pool.Run(8, [&](int task) { partial[task] += task; });
    total = 0;
    for (int value : partial) total += value;
  }
  EXPECT_EQ(total, 200 * 28);  // 0 + 1 + ... + 7 = 28
}

TEST(RankPool, TasksRunAtTheSameTimeOnAllRanks) {
  RankPool pool(3, nullptr);
  std::latch all_there(3);

  // Each task waits for the two others: one rank alone would never end.
  pool.Run(3, [&](int) { all_there.arrive_and_wait(); });

  EXPECT_TRUE(all_there.try_wait());
}

TEST(RankPool, EveryThreadCallsOnStartBeforeItsFirstTask) {
  static thread_local bool started = false;
  std::atomic<int> starts = 0;
  RankPool pool(2, [&] {
    started = true;
    ++starts;
  });
  std::vector<int> seen(2);
  std::latch both(2);

  pool.Run(2, [&](int task) {
    both.arrive_and_wait();
    seen[task] = started;
  });

  EXPECT_EQ(starts, 2);
  EXPECT_THAT(seen, Each(1));
}

TEST(RankPool, ReturnsTheErrorOfTheFirstTaskThatFailed) {
  RankPool pool(2, nullptr);

  const absl::Status status = pool.TryRun(4, [](int task) {
    return task < 2 ? absl::OkStatus()
                    : absl::InternalError(std::to_string(task));
  });

  EXPECT_EQ(status, absl::InternalError("2"));
  EXPECT_TRUE(pool.TryRun(4, [](int) { return absl::OkStatus(); }).ok());
}

TEST(RankPool, EndsWithoutEverHavingRun) { RankPool pool(2, nullptr); }

}  // namespace
}  // namespace sinew::learner
