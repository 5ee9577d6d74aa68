#include "learner/trainer/plateau.h"

#include <gtest/gtest.h>

namespace sinew::learner {
namespace {

v1::Plateau MakeRecipe(int evaluations, double gain = 0.0625,
                       int64_t min_samples = 0) {
  v1::Plateau recipe;
  recipe.set_evaluations(evaluations);
  recipe.set_gain(gain);
  recipe.set_min_samples(min_samples);
  return recipe;
}

TEST(Plateau, IsReachedAfterSoManyEvaluationsWithoutAGain) {
  Plateau plateau(MakeRecipe(3));

  plateau.Observe(0.5, 100);
  plateau.Observe(0.25, 200);
  plateau.Observe(0.5625, 300);  // by the gain, not by more
  EXPECT_FALSE(plateau.reached());
  EXPECT_EQ(plateau.state().stalled(), 2);
  plateau.Observe(0.5, 400);

  EXPECT_TRUE(plateau.reached());
  EXPECT_EQ(plateau.state().best_share(), 0.5);
  EXPECT_EQ(plateau.state().stalled(), 3);
}

TEST(Plateau, BeginsAnewWithEveryGain) {
  Plateau plateau(MakeRecipe(2));

  plateau.Observe(0.5, 100);
  plateau.Observe(0.5, 200);
  plateau.Observe(0.75, 300);
  EXPECT_EQ(plateau.state().stalled(), 0);
  EXPECT_EQ(plateau.state().best_share(), 0.75);
  plateau.Observe(0.5, 400);
  EXPECT_FALSE(plateau.reached());
  plateau.Observe(0.5, 500);

  EXPECT_TRUE(plateau.reached());
}

TEST(Plateau, ASlowRiseAddsUp) {
  Plateau plateau(MakeRecipe(2));

  for (int i = 0; i < 10; ++i) plateau.Observe(0.25 + 0.046875 * i, 100 * i);

  EXPECT_FALSE(plateau.reached());
}

TEST(Plateau, TheFirstEvaluationIsAGainEvenIfNothingSucceeds) {
  Plateau plateau(MakeRecipe(2));

  plateau.Observe(0, 100);

  EXPECT_TRUE(plateau.state().started());
  EXPECT_EQ(plateau.state().stalled(), 0);
  plateau.Observe(0, 200);
  EXPECT_FALSE(plateau.reached());
  plateau.Observe(0, 300);
  EXPECT_TRUE(plateau.reached());
}

TEST(Plateau, DoesNotCountWhatIsBeforeItsSamples) {
  Plateau plateau(MakeRecipe(1, 0.0625, 1000));

  plateau.Observe(0.75, 100);
  plateau.Observe(0.25, 999);
  EXPECT_FALSE(plateau.state().started());
  plateau.Observe(0.25, 1000);
  EXPECT_FALSE(plateau.reached());
  plateau.Observe(0.25, 1100);

  EXPECT_TRUE(plateau.reached());
  EXPECT_EQ(plateau.state().best_share(), 0.25);
}

TEST(Plateau, OnceReachedNothingChangesIt) {
  Plateau plateau(MakeRecipe(1));
  plateau.Observe(0.5, 100);
  plateau.Observe(0.5, 200);

  plateau.Observe(1, 300);

  EXPECT_TRUE(plateau.reached());
  EXPECT_EQ(plateau.state().best_share(), 0.5);
}

TEST(Plateau, OfNoEvaluationsIsNeverReached) {
  Plateau plateau(MakeRecipe(0));

  for (int i = 0; i < 100; ++i) plateau.Observe(0, i);

  EXPECT_FALSE(plateau.enabled());
  EXPECT_FALSE(plateau.reached());
  EXPECT_FALSE(plateau.state().started());
}

TEST(Plateau, GoesOnFromARestoredState) {
  Plateau plateau(MakeRecipe(2));
  plateau.Observe(0.5, 100);
  plateau.Observe(0.5, 200);
  Plateau other(MakeRecipe(2));

  other.Restore(plateau.state());
  other.Observe(0.5, 300);

  EXPECT_TRUE(other.reached());
}

TEST(Plateau, ForgetsAllThatAnotherLibrarySaid) {
  Plateau plateau(MakeRecipe(1));
  plateau.Observe(0.5, 100);
  plateau.Observe(0.5, 200);

  plateau.Migrate();

  EXPECT_FALSE(plateau.reached());
  EXPECT_FALSE(plateau.state().started());
}

}  // namespace
}  // namespace sinew::learner
