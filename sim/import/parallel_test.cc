#include "sim/import/parallel.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <vector>

namespace sinew::import {
namespace {

TEST(ForEachIndex, CallsEveryTaskOnce) {
  for (const int threads : {1, 2, 7, 100}) {
    std::vector<std::atomic<int>> calls(50);
    ForEachIndex(50, threads, StopToken(), [&](int i) { ++calls[i]; });
    for (const auto& count : calls) EXPECT_EQ(count, 1) << threads;
  }
}

TEST(ForEachIndex, BeginsNothingAfterAStop) {
  StopSource stop;
  std::atomic<int> calls = 0;
  ForEachIndex(50, 1, stop.get_token(), [&](int i) {
    ++calls;
    if (i == 4) stop.request_stop();
  });
  EXPECT_EQ(calls, 5);
}

TEST(ForEachIndex, HasNothingToDoWithoutTasks) {
  ForEachIndex(0, 4, StopToken(), [](int) { FAIL(); });
}

}  // namespace
}  // namespace sinew::import
