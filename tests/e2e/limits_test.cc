// A run that its replay could not hold is refused before it begins.
#include <string>

#include "common/files.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/testing/training_rig.h"

namespace sinew::tests {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

// Three clips: 300 thousand starts, at 4 KiB and more each.
const TrainingRig::Arguments kManyStarts = {"--set",
                                            "evaluation.starts=100000"};

TEST(LimitsTest, RefusesAnEvaluationThatReplayCannotHold) {
  const TrainingRig rig;

  EXPECT_EQ(rig.Run("run", rig.Train("run", 3, kManyStarts)).code, kMisused);

  EXPECT_THAT(
      rig.Output("run"),
      AllOf(HasSubstr("rollouts.replay_bytes"), HasSubstr("expected >="),
            HasSubstr("300000 starts of an evaluation"),
            HasSubstr("found 268435456")));
  EXPECT_FALSE(FileExists(rig.Path("run")));
}

TEST(LimitsTest, RefusesAnEvaluationThatReplayElsewhereCannotHold) {
  const TrainingRig rig;
  const auto replay = rig.Start(
      "replay", {"replay", "--listen", "127.0.0.1:0", "--bytes", "2097152"});
  TrainingRig::Arguments more = kManyStarts;
  more.insert(more.end(), {"--listen", "127.0.0.1:0", "--replay",
                           rig.AwaitAddress(*replay, "replay")});

  EXPECT_EQ(rig.Run("learner", rig.Learner("run", 3, more)).code, kMisused);

  EXPECT_THAT(rig.Output("learner"),
              AllOf(HasSubstr("--bytes of a replay elsewhere"),
                    HasSubstr("found 2097152")));
}

}  // namespace
}  // namespace sinew::tests
