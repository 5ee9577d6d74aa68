#include "common/stop_signal.h"

#include <gtest/gtest.h>
#include <signal.h>

namespace sinew {
namespace {

TEST(StopSignal, AsksToStopOnTheFirstAndQuitsOnTheSecond) {
  CatchStopSignals();
  EXPECT_FALSE(StopRequested());

  raise(SIGTERM);

  EXPECT_TRUE(StopRequested());
  EXPECT_EXIT(raise(SIGINT), ::testing::ExitedWithCode(130), "");
}

}  // namespace
}  // namespace sinew
