#include "teacher/block_pool.h"

#include <atomic>
#include <thread>
#include <vector>

#include "gtest/gtest.h"

namespace sinew::teacher {
namespace {

TEST(BlockPool, RunsEveryBlockOnceOnWorkersThatThereAre) {
  for (const int workers : {1, 2, 5}) {
    BlockPool pool(workers);
    for (const int64_t blocks : {0, 1, 3, 100}) {
      std::vector<std::atomic<int>> runs(blocks);
      std::atomic<bool> known = true;

      pool.Run(blocks, [&](int worker, int64_t block) {
        ++runs[block];
        if (worker < 0 || worker >= workers) known = false;
      });

      EXPECT_TRUE(known) << workers << " " << blocks;
      for (const auto& count : runs) EXPECT_EQ(count, 1);
    }
  }
}

TEST(BlockPool, LetsCallersTakeTurns) {
  BlockPool pool(3);
  // Without turns, two callers would be worker 0 at once.
  std::atomic<int> in_worker_0 = 0;
  std::atomic<bool> alone = true;
  std::atomic<int> total = 0;
  {
    std::vector<std::jthread> callers;
    for (int i = 0; i < 4; ++i) {
      callers.emplace_back([&] {
        for (int run = 0; run < 50; ++run) {
          pool.Run(4, [&](int worker, int64_t) {
            ++total;
            if (worker != 0) return;
            if (++in_worker_0 != 1) alone = false;
            --in_worker_0;
          });
        }
      });
    }
  }

  EXPECT_TRUE(alone);
  EXPECT_EQ(total, 4 * 50 * 4);
}

}  // namespace
}  // namespace sinew::teacher
