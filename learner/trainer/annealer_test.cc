#include "learner/trainer/annealer.h"

#include <gtest/gtest.h>

namespace sinew::learner {
namespace {

v1::Anneal MakeRecipe(double success_share, int stall_evaluations) {
  v1::Anneal recipe;
  recipe.set_success_share(success_share);
  recipe.set_stall_evaluations(stall_evaluations);
  recipe.set_samples(1000);
  recipe.set_std_factor(0.25);
  recipe.set_learning_rate_factor(0.01);
  return recipe;
}

TEST(Annealer, ChangesNothingBeforeItStarts) {
  Annealer annealer(MakeRecipe(1, 0));

  annealer.Observe(0.9, 0.95, 5000);

  EXPECT_EQ(annealer.StdFactor(9000), 1);
  EXPECT_EQ(annealer.LearningRateFactor(9000), 1);
}

TEST(Annealer, FallsGeometricallyOnceAllStartsSucceed) {
  Annealer annealer(MakeRecipe(1, 0));

  annealer.Observe(1, 1, 5000);

  EXPECT_EQ(annealer.StdFactor(5000), 1);
  EXPECT_DOUBLE_EQ(annealer.StdFactor(5500), 0.5);  // 0.25^(1/2)
  EXPECT_DOUBLE_EQ(annealer.LearningRateFactor(5500), 0.1);
  EXPECT_DOUBLE_EQ(annealer.StdFactor(99000), 0.25);
}

TEST(Annealer, DoesNotStartAgainWhenStartsFailLater) {
  Annealer annealer(MakeRecipe(1, 0));
  annealer.Observe(1, 1, 5000);

  annealer.Observe(0, 0.1, 5400);
  annealer.Observe(1, 1, 5500);

  EXPECT_EQ(annealer.state().start_samples(), 5000);
}

TEST(Annealer, StartsWhenSurvivalStalls) {
  Annealer annealer(MakeRecipe(1, 2));

  annealer.Observe(0, 0.3, 1000);
  annealer.Observe(0, 0.305, 2000);  // within the margin: stalled once
  EXPECT_FALSE(annealer.state().started());
  annealer.Observe(0, 0.2, 3000);

  EXPECT_TRUE(annealer.state().started());
  EXPECT_EQ(annealer.state().start_samples(), 3000);
}

TEST(Annealer, StartsAfterItsSamplesWhateverEvaluationsSay) {
  v1::Anneal recipe = MakeRecipe(0, 0);
  recipe.set_begin_samples(3000);
  Annealer annealer(recipe);

  annealer.Advance(2999, 1);
  EXPECT_FALSE(annealer.state().started());
  annealer.Advance(3100, 2);
  annealer.Advance(3200, 3);

  EXPECT_EQ(annealer.state().start_samples(), 3100);
  EXPECT_FALSE(annealer.Finished(4099));
  EXPECT_TRUE(annealer.Finished(4100));
}

TEST(Annealer, StartsAfterItsIterationsHoweverFewSamplesTheyHad) {
  v1::Anneal recipe = MakeRecipe(0, 0);
  recipe.set_begin_iteration(3);
  Annealer annealer(recipe);

  annealer.Advance(9'000'000, 2);
  EXPECT_FALSE(annealer.state().started());
  annealer.Advance(9'000'001, 3);
  annealer.Advance(9'000'002, 4);

  EXPECT_EQ(annealer.state().start_samples(), 9'000'001);
}

TEST(Annealer, NeverStartsByItselfWithoutAReason) {
  Annealer annealer(MakeRecipe(0, 0));

  annealer.Advance(1'000'000, 1000);
  EXPECT_FALSE(annealer.state().started());
  EXPECT_FALSE(annealer.Finished(2'000'000));
  annealer.Start(1'000'000);
  annealer.Start(1'500'000);

  EXPECT_EQ(annealer.state().start_samples(), 1'000'000);
}

TEST(Annealer, GoesOnFromARestoredState) {
  Annealer annealer(MakeRecipe(1, 0));
  annealer.Observe(1, 1, 5000);
  Annealer other(MakeRecipe(1, 0));

  other.Restore(annealer.state());

  EXPECT_EQ(other.StdFactor(5300), annealer.StdFactor(5300));
}

}  // namespace
}  // namespace sinew::learner
