#include "learner/trainer/trainer.h"

#include <cmath>
#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "common/digest.h"
#include "common/policy/safetensors.h"
#include "common/testing/matchers.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "learner/trainer/testing/fake_experience.h"
#include "learner/trainer/testing/trainer_rig.h"

namespace sinew::learner {
namespace {

using ::sinew::testing::IsOk;
using ::sinew::testing::StatusIs;
using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

TEST(Trainer, CollectsThenLearnsUnderLagZero) {
  Rig run(MakeRecipe());

  run.Iterate(3);

  EXPECT_THAT(run.experience.log(),
              ElementsAre("publish 0",                             //
                          "begin train 0 with 0", "take train 0",  //
                          "publish 1",                             //
                          "begin train 1 with 1", "take train 1",  //
                          "publish 2", "begin evaluate 2 with 2",  //
                          "begin train 2 with 2", "take train 2",  //
                          "take evaluate 2", "publish 3"));
}

TEST(Trainer, CollectsWhileLearningUnderLagOne) {
  Rig run(MakeRecipe(kLagOne));

  run.Iterate(4);

  // Orders of k + 1 are out before the update that makes snapshot k + 1.
  EXPECT_THAT(
      run.experience.log(),
      ElementsAre("publish 0",                                          //
                  "begin train 0 with 0", "take train 0",               //
                  "begin train 1 with 0", "publish 1",                  //
                  "take train 1", "begin train 2 with 1", "publish 2",  //
                  "begin evaluate 2 with 2",                            //
                  "take train 2", "begin train 3 with 2", "publish 3",  //
                  "take train 3", "take evaluate 2",                    //
                  "begin train 4 with 3", "publish 4",                  //
                  "begin evaluate 4 with 4"));
}

TEST(Trainer, OrdersNameTheDigestOfTheSnapshotThatTheyAreRunWith) {
  for (const std::string overrides : {"", kLagOne}) {
    Rig run(MakeRecipe(overrides));
    run.Iterate(4);

    ASSERT_FALSE(run.experience.orders().empty());
    for (const v1::Order& order : run.experience.orders()) {
      const PublishedSnapshot& snapshot =
          run.experience.published()[order.snapshot_version()];
      EXPECT_EQ(snapshot.snapshot.version(), order.snapshot_version());
      EXPECT_EQ(snapshot.sha256, order.snapshot_sha256());
      EXPECT_EQ(snapshot.sha256, Sha256Hex(snapshot.bytes));
      EXPECT_EQ(order.assets_sha256(), "assets");
      EXPECT_EQ(order.layout_sha256(), "layout");
    }
  }
}

TEST(Trainer, PublishesThePolicyAloneWithItsWeights) {
  Rig run(MakeRecipe());
  run.Iterate();

  const v1::Snapshot& snapshot = run.trainer->snapshot().snapshot;

  ASSERT_EQ(snapshot.graph().graphs_size(), 1);
  EXPECT_EQ(snapshot.graph().graphs(0).name(), "policy");
  const auto weights = ParseSafetensors(snapshot.weights(), "snapshot");
  ASSERT_THAT(weights, IsOk());
  EXPECT_EQ(static_cast<int>(weights->size()),
            snapshot.graph().parameters_size());
  const TensorMap all = run.trainer->learner().weights();
  for (const auto& [name, tensor] : *weights) {
    EXPECT_EQ(tensor.data, all.at(name).data) << name;
  }
  EXPECT_LT(weights->size(), all.size());  // the critic's stay at home
}

TEST(Trainer, AnEvaluationTakesEffectExactlyAfterItsDelay) {
  for (const int delay : {1, 2}) {
    Rig run(MakeRecipe(absl::StrCat("evaluation { delay: ", delay, " }")));
    for (int64_t iteration = 1; iteration <= 6; ++iteration) {
      const IterationReport report = run.Iterate();

      // Begun at 2, 4, 6.
      const int64_t begun = iteration - delay;
      const bool due = begun >= 2 && begun % 2 == 0;
      EXPECT_EQ(report.evaluation.has_value(), due) << iteration;
      EXPECT_EQ(report.evaluated_iteration, due ? begun : -1) << iteration;
      if (!due) continue;
      EXPECT_EQ(report.evaluation->overall.starts, 3);
      // From snapshot 3 on they succeed.
      EXPECT_EQ(report.evaluation->overall.succeeded_starts, begun < 3 ? 0 : 3);
      EXPECT_EQ(report.evaluation_core_seconds, 0.5);
    }
  }
}

TEST(Trainer, ASuccessfulEvaluationLowersNoiseInTheNextSnapshot) {
  Rig run(MakeRecipe());
  const auto std_of = [](const PublishedSnapshot& snapshot) {
    const auto weights =
        ParseSafetensors(snapshot.snapshot.weights(), "snapshot");
    return weights->at("policy/std").float32()[0];
  };

  run.Iterate(5);  // the evaluation of snapshot 4 takes effect
  EXPECT_FLOAT_EQ(std_of(run.trainer->snapshot()), 0.3f);
  run.Iterate();

  // One iteration of 64 samples: 0.3 * 0.5^(64 / 1000), less a few samples
  // that the problem marks as invalid (none here).
  EXPECT_NEAR(std_of(run.trainer->snapshot()), 0.3 * std::pow(0.5, 0.064),
              1e-6);
}

TEST(Trainer, ReportsWhatTheSegmentsSay) {
  Rig run(MakeRecipe(kLagOne));

  const IterationReport first = run.Iterate();
  run.experience.carried = true;
  const IterationReport second = run.Iterate();

  EXPECT_EQ(first.iteration, 1);
  EXPECT_EQ(second.samples, 128);  // 2 x 8 environments x 8 steps
  EXPECT_EQ(second.policy_version, 2);
  EXPECT_EQ(first.policy_lag, 0);
  EXPECT_EQ(second.policy_lag, 1);
  // One episode per environment, in turn for each of four reasons.
  EXPECT_EQ(second.episodes, 8);
  EXPECT_EQ(second.failed_episodes, 2);
  EXPECT_EQ(second.time_limit_episodes, 2);
  EXPECT_EQ(second.clip_end_episodes, 2);
  EXPECT_EQ(first.carried_episodes, 0);
  EXPECT_EQ(second.carried_episodes, 4);
  EXPECT_EQ(second.diverged, 2);
  EXPECT_EQ(second.mean_episode_steps, 8);
  EXPECT_EQ(second.physics_steps, 256);
  EXPECT_EQ(second.rollout_seconds.simulate(), 0.5);
}

class TrainerResume : public ::testing::TestWithParam<const char*> {};

// Evaluations are pending at 2 and 4, and under lag 1 at 3 and 5, too.
TEST_P(TrainerResume, ARunThatWasInterruptedEndsWithTheSameBits) {
  const v1::Recipe recipe = MakeRecipe(GetParam());
  Rig whole(recipe);
  whole.Iterate(6);
  const std::string expected = Bits(whole.trainer->Save());
  Rig first(recipe, /*ranks=*/2);
  for (int iterations = 0; iterations <= 5; ++iterations) {
    if (iterations > 0) first.Iterate();

    Rig second(recipe);
    ASSERT_THAT(second.trainer->Restore(first.trainer->Save()), IsOk());
    EXPECT_EQ(Bits(second.trainer->Save()), Bits(first.trainer->Save()));
    second.Iterate(6 - iterations);

    EXPECT_EQ(Bits(second.trainer->Save()), expected)
        << "interrupted after " << iterations;
  }
}

TEST_P(TrainerResume, OrdersThatWereBegunEarlyChangeNothing) {
  const v1::Recipe recipe = MakeRecipe(GetParam());
  Rig whole(recipe), early(recipe);
  whole.Iterate(4);
  for (int i = 0; i < 4; ++i) {
    ASSERT_THAT(early.trainer->BeginNext(), IsOk());
    Rig resumed(recipe);
    ASSERT_THAT(resumed.trainer->Restore(early.trainer->Save()), IsOk());
    resumed.Iterate(4 - i);
    EXPECT_EQ(Bits(resumed.trainer->Save()), Bits(whole.trainer->Save())) << i;
    early.Iterate();
  }

  EXPECT_EQ(Bits(early.trainer->Save()), Bits(whole.trainer->Save()));
}

TEST_P(TrainerResume, AFailedTakeLeavesAStateToSaveOrToGoOnFrom) {
  const v1::Recipe recipe = MakeRecipe(GetParam());
  Rig whole(recipe);
  whole.Iterate(5);
  const std::string expected = Bits(whole.trainer->Save());
  Rig run(recipe);
  for (int i = 0; i < 5; ++i) {
    run.experience.next_take = absl::CancelledError("stopped");
    EXPECT_THAT(run.trainer->RunIteration(),
                StatusIs(absl::StatusCode::kCancelled, "stopped"));
    ASSERT_TRUE(run.trainer->at_rest());
    Rig resumed(recipe);
    ASSERT_THAT(resumed.trainer->Restore(run.trainer->Save()), IsOk());
    resumed.Iterate(5 - i);
    EXPECT_EQ(Bits(resumed.trainer->Save()), expected) << i;
    run.Iterate();
  }

  EXPECT_EQ(Bits(run.trainer->Save()), expected);
}

std::string LagName(const ::testing::TestParamInfo<const char*>& info) {
  constexpr const char* kNames[] = {"LagZero", "LagZeroDelayTwo", "LagOne",
                                    "AdaptiveBins", "PhcSoftLagOne"};
  return kNames[info.index];
}

const char kAdaptive[] =
    "task { start { rule: RULE_ADAPTIVE_BINS bin_seconds: 0.3 } }";
const char kPhcSoftLagOne[] =
    "task { start { rule: RULE_PHC_SOFT bin_seconds: 0.3 } } "
    "rollouts { max_policy_lag: 1 } evaluation { delay: 2 }";

INSTANTIATE_TEST_SUITE_P(Lags, TrainerResume,
                         ::testing::Values("", "evaluation { delay: 2 }",
                                           kLagOne, kAdaptive, kPhcSoftLagOne),
                         LagName);

TEST(Trainer, RefusesTheStateOfAnotherRecipeOrOfOtherAssets) {
  Rig run(MakeRecipe());
  run.Iterate();
  const Trainer::State state = run.trainer->Save();

  Rig other_recipe(MakeRecipe("ppo { discount: 0.9 }"));
  EXPECT_THAT(other_recipe.trainer->Restore(state),
              StatusIs(absl::StatusCode::kFailedPrecondition,
                       HasSubstr("training state: recipe (it has changed")));
  Rig other_assets(MakeRecipe(), 1, "other assets");
  EXPECT_THAT(
      other_assets.trainer->Restore(state),
      StatusIs(absl::StatusCode::kFailedPrecondition,
               AllOf(HasSubstr("training state: assets (character or motions"),
                     HasSubstr("expected assets, found other assets"))));
}

TEST(Trainer, RefusesADamagedState) {
  Rig run(MakeRecipe());
  run.Iterate(2);
  const Trainer::State good = run.trainer->Save();
  ASSERT_EQ(good.counters.snapshots_size(), 2);

  Trainer::State newer = good;
  newer.counters.set_format_version(2);
  Trainer::State flipped = good;
  flipped.snapshots[1][10] ^= 1;
  Trainer::State lacking = good;
  lacking.snapshots.pop_back();
  Trainer::State lonely = good;
  lonely.counters.mutable_environments()->RemoveLast();
  Trainer::State other = good;
  other.counters.set_run_id("other");

  EXPECT_THAT(run.trainer->Restore(newer),
              StatusIs(absl::StatusCode::kFailedPrecondition,
                       HasSubstr("format_version: expected 1, found 2")));
  EXPECT_THAT(run.trainer->Restore(flipped),
              StatusIs(absl::StatusCode::kFailedPrecondition,
                       HasSubstr("snapshot 2: SHA-256: expected")));
  EXPECT_THAT(run.trainer->Restore(lacking),
              StatusIs(absl::StatusCode::kFailedPrecondition,
                       HasSubstr("number of snapshots")));
  EXPECT_THAT(run.trainer->Restore(lonely),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("expected 8 environments")));
  EXPECT_THAT(
      run.trainer->Restore(other),
      StatusIs(absl::StatusCode::kFailedPrecondition, HasSubstr("run_id")));
}

TEST(Trainer, RefusesARecipeThatCouldWaitForItself) {
  v1::Recipe recipe = MakeRecipe();
  const v1::Recipe valid = recipe;
  auto learner = PpoLearner::Create(
      valid, {.observation_width = 6, .action_width = 3, .ranks = 1});
  ASSERT_THAT(learner, IsOk());
  recipe.mutable_rollouts()->set_max_policy_lag(1);  // delay stays 1
  FakeExperience experience(kProblem);

  EXPECT_THAT(Trainer::Create({.recipe = recipe,
                               .library = MakeLibrary(),
                               .run_id = "run",
                               .assets_sha256 = "assets",
                               .layout_sha256 = "layout"},
                              *std::move(learner), experience),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("evaluation.delay: expected >= 2")));
}

}  // namespace
}  // namespace sinew::learner
