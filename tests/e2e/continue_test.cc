// A run that moves to another machine by its compact state.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "learner/trainer/trainer.h"
#include "sim/world/testing/toy_world.h"
#include "tests/testing/training_rig.h"

namespace sinew::tests {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

// Three iterations of a run, and its compact state.
class ContinueTest : public ::testing::Test {
 protected:
  ContinueTest() {
    rig_.MustRun("first", rig_.Train("run", 3));
    rig_.MustRun("export", {"export", "--run", rig_.Path("run"), "--state",
                            rig_.Path("state")});
  }

  TrainingRig::Arguments Continue(
      const std::string& run, int iterations,
      const TrainingRig::Arguments& more = {}) const {
    TrainingRig::Arguments all = {"--continue", rig_.Path("state")};
    all.insert(all.end(), more.begin(), more.end());
    return rig_.Train(run, iterations, all);
  }

  const TrainingRig rig_;
};

TEST_F(ContinueTest, GoesOnWithWhatWasLearnedInAnotherFolder) {
  const v1::TrainingState before = rig_.StateOf("run").counters;

  rig_.MustRun("second", Continue("moved", 5));
  rig_.MustRun("again", Continue("again", 5));

  const learner::Trainer::State moved = rig_.StateOf("moved");
  EXPECT_EQ(moved.counters.iteration(), 5);
  EXPECT_EQ(moved.counters.samples(), before.samples() + 2 * 64);
  EXPECT_GT(before.policy_optimiser_step(), 0);
  EXPECT_GT(moved.counters.policy_optimiser_step(),
            before.policy_optimiser_step());
  EXPECT_EQ(rig_.Rows("moved"), 2);
  EXPECT_EQ(Fingerprint(moved), rig_.FingerprintOf("again"));

  // From then on it is a run like any other.
  rig_.MustRun("third", Continue("moved", 6));
  EXPECT_EQ(rig_.Rows("moved"), 3);
}

TEST_F(ContinueTest, RefusesAnotherRecipeAndOtherWeights) {
  EXPECT_EQ(
      rig_.Run("recipe", Continue("a", 5, {"--set", "ppo.epochs=3"})).code,
      kFailed);
  EXPECT_THAT(rig_.Output("recipe"), HasSubstr("(changed: recipe)"));

  EXPECT_EQ(
      rig_.Run("init", Continue("b", 5, {"--init", rig_.Path("run/bundle")}))
          .code,
      kMisused);
  EXPECT_THAT(rig_.Output("init"), HasSubstr("--continue"));
}

TEST_F(ContinueTest, TakesAnotherLibraryOnlyIfAskedTo) {
  world::testing::LeaveOutOnDisk(2, rig_.ToyFile("library"));

  EXPECT_EQ(rig_.Run("refused", Continue("moved", 5)).code, kFailed);
  EXPECT_THAT(rig_.Output("refused"), AllOf(HasSubstr("motion library"),
                                            HasSubstr("--migrate-library")));
  rig_.MustRun("migrated", Continue("moved", 5, {"--migrate-library"}));

  EXPECT_EQ(rig_.StateOf("moved").counters.iteration(), 5);
}

}  // namespace
}  // namespace sinew::tests
