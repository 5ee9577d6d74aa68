#include "learner/distillation/annealing.h"

#include <gtest/gtest.h>

namespace sinew::learner {
namespace {

v1::Distillation Annealed(int64_t begin, int64_t end) {
  v1::Distillation recipe;
  recipe.set_kl_weight(0.01);
  recipe.set_kl_weight_final(0.001);
  recipe.set_kl_anneal_begin(begin);
  recipe.set_kl_anneal_end(end);
  recipe.set_learning_rate(8e-4);
  recipe.set_learning_rate_final(1e-4);
  recipe.set_rate_anneal_begin(10 * begin);
  recipe.set_rate_anneal_end(10 * end);
  return recipe;
}

TEST(KlWeight, FallsLinearlyBetweenItsMarks) {
  const v1::Distillation recipe = Annealed(1000, 2000);

  EXPECT_DOUBLE_EQ(KlWeight(recipe, 0), 0.01);
  EXPECT_DOUBLE_EQ(KlWeight(recipe, 1000), 0.01);
  // A third of the way: 0.01 - 0.009 / 3.
  EXPECT_NEAR(KlWeight(recipe, 1333), 0.01 - 0.009 * 0.333, 1e-12);
  EXPECT_DOUBLE_EQ(KlWeight(recipe, 2000), 0.001);
  EXPECT_DOUBLE_EQ(KlWeight(recipe, 1 << 30), 0.001);
}

TEST(KlWeight, IsTheFinalOneFromTheStartByDefault) {
  EXPECT_DOUBLE_EQ(KlWeight(Annealed(0, 0), 0), 0.001);
}

TEST(LearningRate, FallsByEqualFactorsBetweenItsMarks) {
  const v1::Distillation recipe = Annealed(1000, 2500);

  EXPECT_EQ(LearningRate(recipe, 0), 8e-4);
  EXPECT_EQ(LearningRate(recipe, 10000), 8e-4);
  // An eighth in all: a half after a third of the way.
  EXPECT_NEAR(LearningRate(recipe, 15000), 4e-4, 1e-12);
  EXPECT_NEAR(LearningRate(recipe, 20000), 2e-4, 1e-12);
  EXPECT_EQ(LearningRate(recipe, 25000), 1e-4);
  EXPECT_EQ(LearningRate(recipe, 1 << 30), 1e-4);
}

TEST(LearningRate, StaysWithoutMarks) {
  v1::Distillation recipe;
  recipe.set_learning_rate(8e-4);

  EXPECT_EQ(LearningRate(recipe, 0), 8e-4);
  EXPECT_EQ(LearningRate(recipe, 1 << 30), 8e-4);
}

}  // namespace
}  // namespace sinew::learner
