#include "tools/training/procedure_bounds.h"

#include <gtest/gtest.h>

#include <vector>

namespace sinew::tools {
namespace {

std::vector<learner::FinishedStage> OneStage(double seconds, int iterations) {
  return {{.stage = {},
           .iterations = iterations,
           .train_seconds = seconds,
           .failed = {}}};
}

TEST(ProcedureBounds, NameTheMinutesThatAreOver) {
  TrainingRun::Options options;
  options.recipe.set_max_minutes(1.5);

  EXPECT_EQ(BoundsAfter(options, OneStage(89, 9)).Reached(), "");
  EXPECT_EQ(BoundsAfter(options, OneStage(90, 9)).Reached(),
            "1.5 minutes of all stages are over: give more --minutes");
  options.minutes = 2;  // before those of the recipe
  EXPECT_EQ(BoundsAfter(options, OneStage(90, 9)).Reached(), "");
}

TEST(ProcedureBounds, NameTheIterationsThatAreOver) {
  TrainingRun::Options options;
  options.iterations = 10;
  ProcedureBounds bounds = BoundsAfter(options, OneStage(1, 9));
  EXPECT_EQ(bounds.Reached(), "");

  bounds.Spend(1, 1);

  EXPECT_EQ(bounds.Reached(),
            "10 iterations of all stages are over: give more --iterations");
}

TEST(ProcedureBounds, LimitAStageToWhatIsLeft) {
  TrainingRun::Options options, stage;
  options.minutes = 2;
  options.iterations = 12;
  stage.recipe.set_max_iterations(5);

  BoundsAfter(options, OneStage(30, 4)).Limit(stage);
  EXPECT_DOUBLE_EQ(stage.minutes, 1.5);
  EXPECT_EQ(stage.iterations, 5);

  BoundsAfter(options, OneStage(30, 9)).Limit(stage);
  EXPECT_EQ(stage.iterations, 3);
}

}  // namespace
}  // namespace sinew::tools
