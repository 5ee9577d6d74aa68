#include "replay/run_claim.h"

#include <string>
#include <utility>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/string_view.h"
#include "absl/time/time.h"
#include "common/logging.h"
#include "common/testing/matchers.h"
#include "common/testing/simulated_clock.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace sinew::replay {
namespace {

using ::sinew::testing::IsOk;
using ::sinew::testing::SimulatedClock;
using ::sinew::testing::StatusIs;
using ::testing::AllOf;
using ::testing::HasSubstr;

class RunClaimTest : public ::testing::Test {
 protected:
  RunClaimTest() {
    auto logger = Logger::Create({}, clock_);
    EXPECT_THAT(logger, IsOk());
    (*logger)->SetConsole(
        [this](absl::string_view line) { absl::StrAppend(&log_, line, "\n"); });
    SetProgramLogger(*std::move(logger));
  }
  ~RunClaimTest() override { SetProgramLogger(nullptr); }

  SimulatedClock clock_;
  RunClaim claim_{clock_};
  std::string log_;
};

TEST_F(RunClaimTest, KeepsAnotherRunOutWhileTakesCome) {
  ASSERT_THAT(claim_.Begin("a"), IsOk());
  claim_.Touch();
  clock_.Advance(absl::Seconds(50));
  claim_.Touch();
  clock_.Advance(absl::Seconds(12.4));

  EXPECT_THAT(claim_.Begin("b"),
              StatusIs(absl::StatusCode::kFailedPrecondition,
                       AllOf(HasSubstr("serves \"a\""), HasSubstr("12s ago"),
                             HasSubstr("found \"b\""), HasSubstr("wait 48s"),
                             HasSubstr("or restart replay"))));
  EXPECT_EQ(claim_.run_id(), "a");
}

TEST_F(RunClaimTest, LetsAnotherRunInAMinuteAfterTheLastTakeAndSaysSo) {
  ASSERT_THAT(claim_.Begin("a"), IsOk());
  claim_.Touch();
  clock_.Advance(RunClaim::kActive);

  EXPECT_THAT(claim_.Begin("b"), IsOk());

  EXPECT_EQ(claim_.run_id(), "b");
  EXPECT_THAT(log_, AllOf(HasSubstr("before=a"), HasSubstr("run=b")));
}

TEST_F(RunClaimTest, NeverRefusesTheSameRun) {
  ASSERT_THAT(claim_.Begin("a"), IsOk());
  claim_.Touch();

  EXPECT_THAT(claim_.Begin("a"), IsOk());

  EXPECT_THAT(log_, HasSubstr("run=a"));
}

TEST_F(RunClaimTest, StaysWithARunThatHasStartedAnewUntilItIsSilent) {
  ASSERT_THAT(claim_.Begin("a"), IsOk());
  claim_.Touch();
  ASSERT_THAT(claim_.Begin("a"), IsOk());

  EXPECT_THAT(claim_.Begin("b"),
              StatusIs(absl::StatusCode::kFailedPrecondition));
}

TEST_F(RunClaimTest, LetsAnotherRunInAtOnceAfterOneThatHasEnded) {
  ASSERT_THAT(claim_.Begin("a"), IsOk());
  claim_.Touch();
  claim_.End();

  EXPECT_THAT(claim_.Begin("b"), IsOk());
}

}  // namespace
}  // namespace sinew::replay
