#include "tools/bench/distillation_figures.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "absl/status/status.h"
#include "common/testing/matchers.h"
#include "learner/torch/runtime.h"
#include "proto/sinew/v1/recipe.pb.h"

namespace sinew::bench {
namespace {

using ::sinew::testing::IsOk;
using ::sinew::testing::StatusIs;
using ::testing::HasSubstr;

constexpr LearnerWidths kWidths = {
    .observation = 6, .self_observation = 4, .action = 2};

v1::Recipe SmallStudent() {
  v1::Recipe recipe;
  recipe.set_format_version(1);
  recipe.set_name("small");
  recipe.mutable_rollouts()->set_horizon(8);
  recipe.mutable_distillation()->set_minibatch(32);
  return recipe;
}

void ExpectFigures(const v1::Recipe& recipe) {
  const auto figures = MeasureDistillation(recipe, kWidths, /*minibatches=*/2);

  ASSERT_THAT(figures, IsOk());
  EXPECT_GT(figures->rows_per_s, 0);
  EXPECT_GT(figures->flops_per_s, figures->rows_per_s);
  const bool has = learner::CheckBfloat16(learner::DetectCpu(), "cpu", "").ok();
  EXPECT_EQ(figures->bfloat16_ratio.has_value(), has);
  EXPECT_EQ(figures->bfloat16_reason.empty(), has);
  if (has) {
    EXPECT_DOUBLE_EQ(*figures->bfloat16_ratio * figures->rows_per_s,
                     *figures->bfloat16_rows_per_s);
  }
}

TEST(DistillationFigures, AreMeasuredWithALatent) {
  v1::Recipe recipe = SmallStudent();
  recipe.mutable_network()->mutable_latent()->set_width(3);
  ExpectFigures(recipe);
}

TEST(DistillationFigures, AreMeasuredWithoutALatent) {
  ExpectFigures(SmallStudent());
}

TEST(DistillationFigures, RefuseARecipeWithoutDistillation) {
  v1::Recipe recipe = SmallStudent();
  recipe.clear_distillation();

  EXPECT_THAT(MeasureDistillation(recipe, kWidths, 1).status(),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("recipe small: expected distillation")));
}

}  // namespace
}  // namespace sinew::bench
