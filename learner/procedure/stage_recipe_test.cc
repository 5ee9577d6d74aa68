#include "learner/procedure/stage_recipe.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdint>
#include <limits>
#include <set>
#include <string>
#include <utility>

#include "absl/status/status.h"
#include "common/config/recipe.h"
#include "common/testing/matchers.h"
#include "learner/trainer/annealer.h"

namespace sinew::learner {
namespace {

using ::sinew::testing::EqualsProto;
using ::sinew::testing::IsOk;
using ::sinew::testing::StatusIs;
using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

constexpr char kRecipe[] = R"(
  format_version: 1
  name: "phc"
  task { recovery { far_share: 0.5 } }
  rollouts { environments: 16 environments_per_order: 8 horizon: 10 }
  ppo {
    minibatch: 80
    anneal { success_share: 0.9 stall_evaluations: 4 samples: 500 }
  }
  evaluation { interval: 5 starts: 1 }
  plateau { evaluations: 3 }
  procedure {
    full_samples: 1601
    hard_samples: 1600
    recovery_samples: 160
    composer_samples: 1
    composer_hidden: 32
  }
  max_minutes: 60
  seed: 7
)";

v1::Recipe MakeRecipe() {
  auto recipe = ParseRecipe(kRecipe, "test");
  EXPECT_THAT(recipe, IsOk());
  return WithDefaults(*std::move(recipe));
}

Stage MakeStage(StageKind kind, int primitive = 0) {
  Stage stage;
  stage.kind = kind;
  stage.primitive = primitive;
  return stage;
}

MATCHER(HeedsNoEvaluation, "") {
  return !arg.has_plateau() && arg.ppo().anneal().success_share() == 0 &&
         arg.ppo().anneal().stall_evaluations() == 0;
}

TEST(StageRecipe, OfTheFirstStageIsTheRunOfTheSameRecipe) {
  const v1::Recipe recipe = MakeRecipe();
  v1::Recipe expected = recipe;
  expected.clear_procedure();
  expected.mutable_task()->clear_recovery();
  expected.set_max_minutes(0);
  expected.set_max_iterations(11);  // 1601 / (16 * 10), rounded up
  expected.set_name("phc_primitive_0");
  expected.mutable_ppo()->mutable_anneal()->set_begin_iteration(
      6);  // 11 - 1 - 4

  const v1::Recipe found = StageRecipe(recipe, MakeStage(StageKind::kFull), 0);

  EXPECT_EQ(PrintRecipe(found), PrintRecipe(expected));
  EXPECT_THAT(ValidateRecipe(found), IsOk());
}

TEST(StageRecipe, OfAHardSetStartsInItsClipsAlone) {
  Stage stage = MakeStage(StageKind::kHard);
  stage.clips = {"walk", "run"};

  const v1::Recipe recipe = StageRecipe(MakeRecipe(), stage, 1);

  EXPECT_THAT(recipe.task().start().only_clips(), ElementsAre("walk", "run"));
  EXPECT_EQ(recipe.max_iterations(), 10);
  EXPECT_TRUE(recipe.has_plateau());
  EXPECT_EQ(recipe.ppo().anneal().success_share(), 0.9);
  EXPECT_EQ(recipe.ppo().anneal().stall_evaluations(), 4);
  EXPECT_EQ(recipe.name(), "phc_primitive_0_hard");
}

TEST(StageRecipe, OfRecoveryHasItsStartsAndHeedsNoEvaluation) {
  const v1::Recipe recipe =
      StageRecipe(MakeRecipe(), MakeStage(StageKind::kRecovery, 2), 4);

  EXPECT_EQ(recipe.task().recovery().far_share(), 0.5);
  EXPECT_THAT(recipe, HeedsNoEvaluation());
  EXPECT_EQ(recipe.max_iterations(), 1);
  EXPECT_FALSE(recipe.network().has_composer());
}

TEST(StageRecipe, OfTheComposerHasOneRecoversAndHeedsNoEvaluation) {
  const v1::Recipe recipe =
      StageRecipe(MakeRecipe(), MakeStage(StageKind::kComposer, 3), 5);

  EXPECT_THAT(recipe.network().composer(),
              EqualsProto("primitives: 3 hidden: 32"));
  EXPECT_EQ(recipe.task().recovery().far_share(), 0.5);
  EXPECT_THAT(recipe, HeedsNoEvaluation());
  EXPECT_THAT(ValidateRecipe(recipe), IsOk());
}

// The first stage's, but for what ends it and what has learnt.
TEST(StageRecipe, OfTheSinglePrimitiveIsThatOfTheFirstStageToItsLastSample) {
  v1::Recipe recipe = MakeRecipe();
  recipe.mutable_ppo()->set_value_warmup_iterations(3);
  Stage stage = MakeStage(StageKind::kSingle);
  stage.samples = 3361;
  v1::Recipe expected =
      StageRecipe(recipe, MakeStage(StageKind::kFull), /*index=*/5);
  expected.set_name("phc_single");
  expected.set_max_iterations(22);  // 3361 / (16 * 10), rounded up
  expected.clear_plateau();
  expected.mutable_ppo()->set_value_warmup_iterations(0);
  v1::Anneal& anneal = *expected.mutable_ppo()->mutable_anneal();
  anneal.set_success_share(0);
  anneal.set_stall_evaluations(0);
  anneal.set_begin_iteration(17);  // 22 - 1 - 4

  const v1::Recipe found = StageRecipe(recipe, stage, /*index=*/5);

  EXPECT_EQ(PrintRecipe(found), PrintRecipe(expected));
  EXPECT_THAT(found, HeedsNoEvaluation());
  EXPECT_FALSE(found.task().has_recovery());
  EXPECT_THAT(ValidateRecipe(found), IsOk());
}

TEST(StageRecipe, OfNoStageRecoversIfNoPrimitiveDoes) {
  v1::Recipe recipe = MakeRecipe();
  recipe.mutable_procedure()->set_recovery_samples(0);

  for (const StageKind kind : {StageKind::kFull, StageKind::kHard,
                               StageKind::kGrown, StageKind::kComposer}) {
    const v1::Recipe stage = StageRecipe(recipe, MakeStage(kind, 2), 3);

    EXPECT_FALSE(stage.task().has_recovery()) << KindName(kind);
    EXPECT_TRUE(stage.has_plateau()) << KindName(kind);
    EXPECT_EQ(stage.ppo().anneal().success_share(), 0.9) << KindName(kind);
  }
}

TEST(StageRecipe, WarmsUpValueNetworksThatHaveNotLearnt) {
  v1::Recipe recipe = MakeRecipe();
  recipe.mutable_ppo()->set_value_warmup_iterations(3);
  const auto warmup = [&](StageKind kind) {
    return StageRecipe(recipe, MakeStage(kind, 1), 2)
        .ppo()
        .value_warmup_iterations();
  };

  EXPECT_EQ(warmup(StageKind::kFull), 3);
  EXPECT_EQ(warmup(StageKind::kHard), 0);
  EXPECT_EQ(warmup(StageKind::kGrown), 0);
  EXPECT_EQ(warmup(StageKind::kRecovery), 3);
  EXPECT_EQ(warmup(StageKind::kComposer), 3);
}

TEST(StageRecipe, SettlesBeforeItEnds) {
  v1::Recipe recipe = MakeRecipe();
  const auto begin = [&](StageKind kind) {
    return StageRecipe(recipe, MakeStage(kind, 1), 2)
        .ppo()
        .anneal()
        .begin_iteration();
  };

  // 10 iterations of 160 samples; 500 are 4 of them.
  EXPECT_EQ(begin(StageKind::kHard), 10 - 1 - 4);
  EXPECT_EQ(begin(StageKind::kRecovery), 1);  // one in all
  recipe.mutable_ppo()->mutable_anneal()->set_std_factor(1);
  EXPECT_EQ(begin(StageKind::kHard), 10 - 1 - 4);
  recipe.mutable_ppo()->mutable_anneal()->set_learning_rate_factor(1);
  EXPECT_EQ(begin(StageKind::kHard), 0);
}

TEST(StageRecipe, LearnsLastWithWhatItHasAnnealedTo) {
  for (const int64_t anneal_samples : {1, 100, 160, 161, 500}) {
    v1::Recipe recipe = MakeRecipe();
    v1::Anneal& anneal = *recipe.mutable_ppo()->mutable_anneal();
    anneal.set_samples(anneal_samples);
    const v1::Recipe stage =
        StageRecipe(recipe, MakeStage(StageKind::kHard), 1);

    // As the trainer: an update, then the factor of the next one. Rows of
    // simulations that diverged are no samples.
    for (const int64_t rows : {160, 157}) {
      Annealer annealer(stage.ppo().anneal());
      double factor = 1;
      for (int64_t i = 1; i < stage.max_iterations(); ++i) {
        annealer.Advance(i * rows, i);
        factor = annealer.LearningRateFactor(i * rows);
      }

      EXPECT_NEAR(factor, anneal.learning_rate_factor(),
                  rows == 160 ? 1e-12 : 0.01)
          << anneal_samples << " in " << rows;
    }
  }
}

TEST(StageRecipe, RehearsesWhereThePrimitiveGoesOnAlone) {
  v1::Recipe recipe = MakeRecipe();
  recipe.mutable_procedure()->set_rehearsal_share(0.25);
  const auto share = [&](StageKind kind) {
    Stage stage = MakeStage(kind);
    if (kind != StageKind::kFull) stage.clips = {"walk"};
    return StageRecipe(recipe, stage, 1).task().start().other_clips_share();
  };

  EXPECT_EQ(share(StageKind::kFull), 0);
  EXPECT_EQ(share(StageKind::kHard), 0.25);
  EXPECT_EQ(share(StageKind::kGrown), 0);
}

// Of 16 environments, 10 steps each, minibatches of 80 and an evaluation every
// 5 iterations.
TEST(StageRecipe, GivesEveryClipOfAHardSetItsEnvironments) {
  v1::Recipe recipe = MakeRecipe();
  recipe.mutable_procedure()->set_environments_per_clip(12);
  Stage stage = MakeStage(StageKind::kHard);
  stage.clips = {"walk"};
  EXPECT_EQ(StageRecipe(recipe, stage, 1).rollouts().environments(), 16);

  stage.clips = {"walk", "run", "jump"};
  v1::Recipe found = StageRecipe(recipe, stage, 1);
  EXPECT_EQ(found.rollouts().environments(), 48);  // for 36
  EXPECT_EQ(found.ppo().minibatch(), 240);
  EXPECT_EQ(found.evaluation().interval(), 1);
  EXPECT_EQ(found.rollouts().replay_bytes(), 3 * (256 << 20));
  EXPECT_EQ(found.checkpointing().interval(), 6);  // of 20
  EXPECT_EQ(found.max_iterations(), 4);  // 1600 / (48 * 10), rounded up
  EXPECT_THAT(ValidateRecipe(found), IsOk());

  // Beside as many again as a third of them, for what is rehearsed.
  recipe.mutable_procedure()->set_environments_per_clip(13);
  recipe.mutable_procedure()->set_rehearsal_share(0.25);
  EXPECT_EQ(StageRecipe(recipe, stage, 1).rollouts().environments(), 64);

  stage.kind = StageKind::kFull;
  EXPECT_EQ(StageRecipe(recipe, stage, 0).rollouts().environments(), 16);

  stage.kind = StageKind::kGrown;
  recipe.mutable_procedure()->set_environments_per_clip(kMostEnvironments);
  recipe.mutable_evaluation()->set_delay(2);
  found = StageRecipe(recipe, stage, 1);
  EXPECT_EQ(found.rollouts().environments(), kMostEnvironments);
  EXPECT_EQ(found.evaluation().interval(), 2);
  EXPECT_THAT(ValidateRecipe(found), IsOk());
}

TEST(StageRecipe, TakesAsManySamplesAsThereAre) {
  constexpr int64_t kMost = std::numeric_limits<int64_t>::max();
  v1::Recipe recipe = MakeRecipe();
  recipe.mutable_procedure()->set_full_samples(kMost);

  EXPECT_EQ(
      StageRecipe(recipe, MakeStage(StageKind::kFull), 0).max_iterations(),
      kMost / 160 + 1);
}

TEST(StageRecipe, GivesEveryStageItsOwnSeed) {
  const v1::Recipe recipe = MakeRecipe();
  std::set<uint64_t> seeds;

  for (int i = 0; i < 32; ++i) {
    seeds.insert(StageRecipe(recipe, MakeStage(StageKind::kHard), i).seed());
  }

  EXPECT_EQ(seeds.size(), 32);
}

TEST(ValidateStages, TakesAProcedureWhoseStagesAllMayBeRun) {
  v1::Recipe recipe = MakeRecipe();
  EXPECT_THAT(ValidateStages(recipe), IsOk());

  recipe.mutable_procedure()->set_compare_single(true);
  EXPECT_THAT(ValidateStages(recipe), IsOk());
}

TEST(ValidateStages, NamesTheStageThatCouldNotBeRun) {
  v1::Recipe recipe = MakeRecipe();
  recipe.mutable_procedure()->set_max_primitives(16);

  EXPECT_THAT(ValidateStages(recipe),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       AllOf(HasSubstr("stage composer"),
                             HasSubstr("network.composer.primitives"))));
}

}  // namespace
}  // namespace sinew::learner
