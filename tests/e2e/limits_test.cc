// A run that could not go to its end is refused before it begins.
#include <string>

#include "common/files.h"
#include "common/testing/matchers.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/testing/training_rig.h"

namespace sinew::tests {
namespace {

using ::sinew::testing::IsOk;
using ::sinew::testing::IsOkAndHolds;
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

TEST(LimitsTest, RefusesARunWhoseBundleCouldNotBeExported) {
  const TrainingRig rig;
  const std::string notes = JoinPath(rig.Path("run"), "bundle/notes.txt");
  ASSERT_THAT(MakeDirectories(JoinPath(rig.Path("run"), "bundle")), IsOk());
  ASSERT_THAT(WriteFileAtomically(notes, "mine"), IsOk());

  EXPECT_EQ(rig.Run("out", rig.Train("run", 3)).code, kFailed);

  EXPECT_THAT(rig.Output("out"), HasSubstr("found one that holds notes.txt"));
  EXPECT_THAT(ReadFile(notes), IsOkAndHolds("mine"));
  EXPECT_FALSE(FileExists(JoinPath(rig.Path("run"), "metrics.jsonl")));
}

}  // namespace
}  // namespace sinew::tests
