// How a procedure runs through its stages. tests/e2e/procedure_test.cc trains.

#include "tools/training/procedure_run.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <utility>

#include "absl/strings/str_cat.h"
#include "common/config/recipe.h"
#include "common/files.h"
#include "common/testing/matchers.h"
#include "common/workspace_files.h"
#include "learner/procedure/procedure.h"
#include "learner/procedure/stage_recipe.h"
#include "tools/training/procedure_record.h"
#include "tools/training/testing/procedure_rig.h"

namespace sinew::tools {
namespace {

using ::sinew::testing::IsOk;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

TEST_F(ProcedureRunTest, GoesThroughAllStagesToTheBundleOfTheComposer) {
  MadeUpSteps steps;

  ASSERT_THAT(Run(steps), IsOk());

  EXPECT_EQ(File("bundle/weights"), kComposed);
  EXPECT_EQ(File("eval.json"), "04_composer");
  const ProcedureRecord record = Record();
  ASSERT_THAT(record.Finished(), SizeIs(5));
  EXPECT_THAT(record.stages[2].decision.next->clips, ElementsAre("tumble"));
  EXPECT_THAT(record.stages[3].decision.reason,
              HasSubstr("what is left cannot be learned"));
  ASSERT_TRUE(record.end.has_value());
  EXPECT_THAT(record.end->reason, HasSubstr("composer, which fails 1"));
  EXPECT_THAT(record.end->evidence.hard, ElementsAre("tumble"));
  EXPECT_EQ(record.trained_on_clips, 3);
}

TEST_F(ProcedureRunTest, GivesEachStageItsRecipeAndItsFolder) {
  MadeUpSteps steps;

  ASSERT_THAT(Run(steps), IsOk());

  ASSERT_THAT(steps.trained(), SizeIs(5));
  const TrainingRun::Options& full = steps.trained()[0];
  EXPECT_THAT(full.init, IsEmpty());
  EXPECT_EQ(full.recipe.max_iterations(), 10);
  EXPECT_THAT(full.recipe.task().start().only_clips(), IsEmpty());
  const TrainingRun::Options& hard = steps.trained()[1];
  EXPECT_EQ(hard.directory,
            JoinPath(options_.directory, "stages/01_primitive_0_hard"));
  EXPECT_THAT(hard.recipe.task().start().only_clips(),
              ElementsAre("sway", "tumble"));
  EXPECT_NE(hard.recipe.seed(), full.recipe.seed());
  EXPECT_EQ(hard.init_critic, JoinPath(full.directory, "checkpoints"));
  EXPECT_EQ(hard.init_critic_iteration, 10);
  for (const TrainingRun::Options& stage : steps.trained()) {
    EXPECT_FALSE(stage.recipe.has_procedure());
    EXPECT_THAT(ValidateRecipe(stage.recipe), IsOk());
  }
}

TEST_F(ProcedureRunTest, CountsWhoGetsUpWhereAStageStartsOnTheFloor) {
  MadeUpSteps steps;
  options_.recipe.mutable_task()->mutable_recovery()->set_fallen_share(0.25);

  ASSERT_THAT(Run(steps), IsOk());

  // Recovery and composer.
  EXPECT_THAT(steps.fallen(), ElementsAre(0, 0, 0, 256, 256));
  const ProcedureRecord record = Record();
  ASSERT_THAT(record.stages, SizeIs(5));
  EXPECT_EQ(record.stages[2].recovered, std::nullopt);
  ASSERT_TRUE(record.stages[3].recovered.has_value());
  EXPECT_EQ(record.stages[3].recovered->starts, 256);
  EXPECT_EQ(record.stages[3].recovered->within_3_s, 0.25);
  EXPECT_EQ(record.stages[4].recovered->within_5_s, 0.5);
}

TEST_F(ProcedureRunTest, GoesOnWhereNoClipIsFitToGetUpBeside) {
  MadeUpSteps steps;
  options_.recipe.mutable_task()->mutable_recovery()->set_fallen_share(0.25);
  ProcedureSteps made = steps.Steps();
  made.evaluate = [evaluate = made.evaluate](
                      const auto& bundle, const auto& motions, const auto& out,
                      const auto& options)
      -> absl::StatusOr<evaluation::EvaluationFigures> {
    if (options.fallen) return absl::NotFoundError("expected a clip of");
    return evaluate(bundle, motions, out, options);
  };

  ASSERT_THAT(RunProcedure(options_, made, steps.token()), IsOk());

  EXPECT_THAT(Record().stages, SizeIs(5));
  EXPECT_EQ(Record().stages[4].recovered, std::nullopt);
}

TEST_F(ProcedureRunTest, GoesOnFromAStageThatEndedAtItsPlateau) {
  MadeUpSteps steps;
  steps.SetPlateauStage("00_primitive_0");

  ASSERT_THAT(Run(steps), IsOk());

  const ProcedureRecord record = Record();
  ASSERT_THAT(record.Finished(), SizeIs(5));
  const learner::FinishedStage first = record.Finished()[0];
  EXPECT_TRUE(first.plateau);
  EXPECT_EQ(first.iterations, 3);
  EXPECT_EQ(first.best_share, 0.5);
  EXPECT_EQ(first.stalled, 2);
  EXPECT_FALSE(record.Finished()[1].plateau);
  EXPECT_THAT(record.stages[1].decision.reason,
              HasSubstr("primitive_0 ended at its plateau after 192 samples"));
  EXPECT_EQ(steps.trained()[1].init_critic_iteration, 3);
  EXPECT_EQ(File("bundle/weights"), kComposed);
}

TEST_F(ProcedureRunTest, BeginsWithTheWeightsOfABundleIfAsked) {
  GiveInit("given");
  MadeUpSteps steps;

  ASSERT_THAT(Run(steps), IsOk());

  EXPECT_EQ(File("stages/02_primitive_1/bundle/weights"),
            "02_primitive_1(01_primitive_0_hard(00_primitive_0(given)))");
}

TEST_F(ProcedureRunTest, GoesOnToTheSameEndWhereverItWasStopped) {
  MadeUpSteps straight;
  ASSERT_THAT(Run(straight), IsOk());
  const std::string expected = File("procedure.json");

  for (int calls = 0; calls < 10; ++calls) {
    UseRun(absl::StrCat("cut", calls));
    MadeUpSteps first(calls), second;
    ASSERT_THAT(Run(first), IsOk());
    EXPECT_EQ(File("bundle/weights"), "") << calls;
    ASSERT_THAT(Run(second), IsOk());

    EXPECT_EQ(File("bundle/weights"), kComposed) << calls;
    EXPECT_EQ(File("procedure.json"), expected) << calls;
  }
}

TEST_F(ProcedureRunTest, TrainsASinglePrimitiveOnForAsManySamples) {
  options_.recipe.mutable_procedure()->set_compare_single(true);
  MadeUpSteps steps;

  ASSERT_THAT(Run(steps), IsOk());

  ASSERT_THAT(steps.trained(), SizeIs(6));
  const TrainingRun::Options& single = steps.trained()[5];
  const std::string first =
      JoinPath(options_.directory, "stages/00_primitive_0");
  EXPECT_EQ(single.init, JoinPath(first, "bundle"));
  EXPECT_EQ(single.init_critic, JoinPath(first, "checkpoints"));
  EXPECT_EQ(single.init_critic_iteration, 10);
  EXPECT_THAT(single.primitives, IsEmpty());
  EXPECT_EQ(single.recipe.max_iterations(), 13);  // 5 + 5 + 2 + 1
  EXPECT_THAT(single.recipe.task().start().only_clips(), IsEmpty());
  EXPECT_FALSE(single.recipe.has_plateau());
  EXPECT_EQ(File("stages/05_single/eval.json"), "05_single");
  // 23 iterations of 64 samples each. It wins more, and counts for nothing.
  EXPECT_EQ(File("bundle/weights"), kComposed);
  EXPECT_EQ(File("eval.json"), "04_composer");
  const auto both = learner::Compare(Record().Finished());
  ASSERT_TRUE(both.has_value());
  EXPECT_EQ(both->procedure.stage, 4);
  EXPECT_EQ(both->procedure.samples, 1472);
  EXPECT_EQ(both->procedure.failed, 1);
  EXPECT_EQ(both->single.samples, 1472);
  EXPECT_EQ(both->single.failed, 0);
  EXPECT_THAT(File("procedure.json"), HasSubstr("\"comparison\""));
}

TEST_F(ProcedureRunTest, HasItsPolicyWhileTheSinglePrimitiveIsUnderWay) {
  MadeUpSteps straight;
  options_.recipe.mutable_procedure()->set_compare_single(true);
  ASSERT_THAT(Run(straight), IsOk());
  const std::string expected = File("procedure.json");

  // In its training, then in its evaluation.
  for (int calls = 10; calls < 12; ++calls) {
    UseRun(absl::StrCat("cut", calls));
    MadeUpSteps first(calls), second;
    ASSERT_THAT(Run(first), IsOk());
    EXPECT_EQ(File("bundle/weights"), kComposed) << calls;
    EXPECT_THAT(Record().Finished(), SizeIs(5)) << calls;
    ASSERT_THAT(Run(second), IsOk());

    EXPECT_EQ(File("bundle/weights"), kComposed) << calls;
    EXPECT_EQ(File("procedure.json"), expected) << calls;
  }
}

TEST_F(ProcedureRunTest, TrainsNothingOnceItIsOver) {
  MadeUpSteps first, second;
  ASSERT_THAT(Run(first), IsOk());
  const std::string record = File("procedure.json");

  ASSERT_THAT(Run(second), IsOk());

  EXPECT_THAT(second.trained(), IsEmpty());
  EXPECT_EQ(File("procedure.json"), record);
  EXPECT_EQ(File("bundle/weights"), kComposed);
}

TEST_F(ProcedureRunTest, CountsIterationsOverAllStages) {
  options_.iterations = 12;  // 10 of the first stage
  MadeUpSteps steps;

  ASSERT_THAT(Run(steps), IsOk());

  ASSERT_THAT(steps.trained(), SizeIs(2));
  EXPECT_EQ(steps.trained()[1].iterations, 2);
  EXPECT_THAT(Record().Finished(), SizeIs(1));
  options_.iterations = 0;
  MadeUpSteps rest;
  ASSERT_THAT(Run(rest), IsOk());
  EXPECT_EQ(File("bundle/weights"), kComposed);
}

TEST_F(ProcedureRunTest, CountsIterationsOfTheSinglePrimitiveToo) {
  options_.recipe.mutable_procedure()->set_compare_single(true);
  options_.iterations = 25;  // 23 of all others
  MadeUpSteps steps;

  ASSERT_THAT(Run(steps), IsOk());

  ASSERT_THAT(steps.trained(), SizeIs(6));
  EXPECT_EQ(steps.trained()[5].iterations, 2);
  EXPECT_FALSE(Record().end.has_value());
}

TEST_F(ProcedureRunTest, CountsMinutesOverAllStages) {
  options_.minutes = 1.5;  // each stage takes one
  MadeUpSteps steps;

  ASSERT_THAT(Run(steps), IsOk());

  ASSERT_THAT(steps.trained(), SizeIs(2));
  EXPECT_DOUBLE_EQ(steps.trained()[0].minutes, 1.5);
  EXPECT_DOUBLE_EQ(steps.trained()[1].minutes, 0.5);
  EXPECT_EQ(File("bundle/weights"), "");
}

TEST(ShippedProcedures, HaveStagesThatMayAllBeRun) {
  for (const char* name : {"phc_plus", "phc_plus_g1"}) {
    const auto path =
        FindWorkspaceFile(absl::StrCat("deploy/recipes/", name, ".textproto"));
    ASSERT_THAT(path, IsOk());
    auto recipe = ParseRecipe(ReadFile(*path).value_or(""), *path);
    ASSERT_THAT(recipe, IsOk());
    EXPECT_FALSE(recipe->procedure().compare_single());
    recipe->mutable_procedure()->set_compare_single(true);

    EXPECT_THAT(learner::ValidateStages(WithDefaults(*std::move(recipe))),
                IsOk());
  }
}

}  // namespace
}  // namespace sinew::tools
