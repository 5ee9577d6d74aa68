#include "common/stop.h"

#include <unistd.h>

#include <atomic>
#include <csignal>
#include <thread>

#include "absl/status/status.h"
#include "common/testing/matchers.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace sinew {
namespace {

using ::sinew::testing::IsOk;
using ::sinew::testing::StatusIs;
using ::testing::HasSubstr;

TEST(SignalStop, RequestsStopAtTheFirstSignal) {
  for (const int signal : {SIGINT, SIGTERM}) {
    const auto stop = SignalStop::Install();
    ASSERT_THAT(stop, IsOk());
    EXPECT_FALSE((*stop)->token().stop_requested());

    kill(getpid(), signal);
    AwaitStop((*stop)->token());

    EXPECT_TRUE((*stop)->token().stop_requested());
  }
}

TEST(SignalStopDeathTest, EndsTheProgramAtTheSecondSignal) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");

  EXPECT_EXIT(
      {
        const auto stop = SignalStop::Install();
        raise(SIGINT);
        raise(SIGTERM);
      },
      ::testing::ExitedWithCode(130), "");
}

TEST(SignalStopDeathTest, GivesSignalsBackWhenDestroyed) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");

  EXPECT_EXIT(
      {
        {
          const auto stop = SignalStop::Install();
        }
        raise(SIGTERM);
      },
      ::testing::KilledBySignal(SIGTERM), "");
}

TEST(SignalStop, IsInstalledOnce) {
  const auto first = SignalStop::Install();
  ASSERT_THAT(first, IsOk());

  EXPECT_THAT(SignalStop::Install(),
              StatusIs(absl::StatusCode::kFailedPrecondition,
                       HasSubstr("another SignalStop")));
}

TEST(SignalStop, EndsWithoutAnySignal) {
  StopToken token;
  {
    const auto stop = SignalStop::Install();
    ASSERT_THAT(stop, IsOk());
    token = (*stop)->token();
  }

  EXPECT_FALSE(token.stop_requested());
}

TEST(AwaitStop, ReturnsAtOnceWhenStopWasRequestedBefore) {
  StopSource stop;
  stop.request_stop();

  AwaitStop(stop.get_token());
}

TEST(AwaitStop, ReturnsNotBeforeStopIsRequested) {
  StopSource stop;
  std::atomic<bool> asked = false;
  std::thread other([&] {
    asked = true;
    stop.request_stop();
  });

  AwaitStop(stop.get_token());

  EXPECT_TRUE(asked);
  other.join();
}

TEST(DieWithParent, RefusesWhenTheParentIsAnother) {
  EXPECT_FALSE(DieWithParent(0, getpid()));
  EXPECT_TRUE(DieWithParent(0, getppid()));
}

}  // namespace
}  // namespace sinew
