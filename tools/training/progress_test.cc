#include "tools/training/progress.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "absl/strings/str_cat.h"
#include "common/testing/simulated_clock.h"

namespace sinew::tools {
namespace {

using ::sinew::testing::SimulatedClock;
using ::testing::EndsWith;
using ::testing::HasSubstr;
using ::testing::Not;

ProgressState MakeState() {
  ProgressState state;
  state.iteration = 57;
  state.samples = 466'944;
  state.samples_per_second = 11'240;
  state.reward = 0.7412;
  return state;
}

TEST(ProgressTest, ShowsSpeedSamplesAndReward) {
  EXPECT_EQ(ProgressText(MakeState(), 10),
            "iteration 57  0.47 M samples  11.2 k/s  reward 0.741");
}

TEST(ProgressTest, ShowsTheErrorOfADistillation) {
  ProgressState state = MakeState();
  state.action_error_rad = 0.0314;

  EXPECT_THAT(ProgressText(state, 10),
              EndsWith("reward 0.741  error 0.031 rad"));
}

TEST(ProgressTest, ShowsShareTimeLeftSuccessAndTrouble) {
  ProgressState state = MakeState();
  state.share = 0.25;
  state.seconds_left = 3725;
  state.evaluation = "12/32 starts";
  state.trouble = "1 saves have failed";

  const std::string text = ProgressText(state, 8);

  EXPECT_THAT(text, HasSubstr("[##......]  25 %"));
  EXPECT_THAT(text, HasSubstr("12/32 starts  1:02:05 left"));
  EXPECT_THAT(text, EndsWith("! 1 saves have failed"));
}

TEST(ProgressTest, TellsTimesInMinutesAndFromAnHourOnInHours) {
  EXPECT_EQ(TimeText(-1), "0:00");
  EXPECT_EQ(TimeText(59.6), "1:00");
  EXPECT_EQ(TimeText(3599), "59:59");
  EXPECT_EQ(TimeText(36000), "10:00:00");
}

class ShownProgressTest : public ::testing::Test {
 protected:
  Progress::Options Options(bool is_terminal) {
    Progress::Options options;
    options.is_terminal = is_terminal;
    options.write = [this](absl::string_view text) {
      absl::StrAppend(&shown_, text);
    };
    return options;
  }

  SimulatedClock clock_;
  std::string shown_;
};

TEST_F(ShownProgressTest, IsALineNowAndThenWhereThereIsNoTerminal) {
  Progress progress(Options(/*is_terminal=*/false), clock_);

  progress.Show(MakeState());
  progress.Show(MakeState());
  clock_.Advance(absl::Seconds(10));
  progress.Show(MakeState());

  const std::string line = ProgressText(MakeState(), 24) + "\n";
  EXPECT_EQ(shown_, line + line);
}

TEST_F(ShownProgressTest, DrawsTheBarAgainBelowALineOfText) {
  Progress progress(Options(/*is_terminal=*/true), clock_);
  progress.Show(MakeState());
  shown_.clear();

  progress.Line("saved");

  EXPECT_EQ(shown_,
            absl::StrCat("\r\033[Ksaved\n", ProgressText(MakeState(), 24)));
}

TEST_F(ShownProgressTest, EndsTheBarsLine) {
  {
    Progress progress(Options(/*is_terminal=*/true), clock_);
    progress.Show(MakeState());
    EXPECT_THAT(shown_, Not(EndsWith("\n")));
  }
  EXPECT_THAT(shown_, EndsWith("\n"));
}

}  // namespace
}  // namespace sinew::tools
