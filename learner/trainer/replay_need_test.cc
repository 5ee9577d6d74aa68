#include "learner/trainer/replay_need.h"

#include <cstdint>

#include "absl/status/status.h"
#include "common/segment/segment_size.h"
#include "common/testing/matchers.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "proto/sinew/v1/recipe.pb.h"
#include "proto/sinew/v1/rollout.pb.h"

namespace sinew::learner {
namespace {

using ::sinew::testing::IsOk;
using ::sinew::testing::StatusIs;
using ::testing::AllOf;
using ::testing::HasSubstr;

// 6 environments in orders of 2, 5 steps.
v1::Recipe MakeRecipe() {
  v1::Recipe recipe;
  recipe.mutable_rollouts()->set_environments(6);
  recipe.mutable_rollouts()->set_environments_per_order(2);
  recipe.mutable_rollouts()->set_horizon(5);
  recipe.mutable_evaluation()->set_interval(10);
  recipe.mutable_evaluation()->set_delay(2);
  return recipe;
}

v1::SegmentLayout MakeLayout() {
  v1::SegmentLayout layout;
  v1::SegmentLayout::Column& column = *layout.add_columns();
  column.set_dtype(v1::DATA_TYPE_FLOAT32);
  column.add_shape(100);
  column.set_lead(v1::SegmentLayout::LEAD_STEP);
  return layout;
}

int64_t Training() { return 3 * MaxTrainingBytes(MakeLayout(), 2, 5); }

TEST(ReplayBytesNeeded, AreThoseOfAnIterationAndOneEvaluation) {
  // 7 starts: three orders of 2, one of 1.
  EXPECT_EQ(ReplayBytesNeeded(MakeRecipe(), MakeLayout(), 7),
            Training() + 3 * MaxEvaluationBytes(2) + MaxEvaluationBytes(1));
  EXPECT_EQ(ReplayBytesNeeded(MakeRecipe(), MakeLayout(), 8),
            Training() + 4 * MaxEvaluationBytes(2));
}

TEST(ReplayBytesNeeded, AreThoseOfAnIterationWhereNothingIsEvaluated) {
  v1::Recipe recipe = MakeRecipe();
  recipe.mutable_evaluation()->set_interval(0);

  EXPECT_EQ(ReplayBytesNeeded(recipe, MakeLayout(), 7), Training());
}

TEST(CheckReplayHolds, NamesWhatAsksForMoreThanThereIs) {
  const int64_t needed = ReplayBytesNeeded(MakeRecipe(), MakeLayout(), 7);

  EXPECT_THAT(CheckReplayHolds(MakeRecipe(), MakeLayout(), 7, needed), IsOk());
  EXPECT_THAT(CheckReplayHolds(MakeRecipe(), MakeLayout(), 7, needed - 1),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       AllOf(HasSubstr("rollouts.replay_bytes"),
                             HasSubstr("7 starts of an evaluation"))));

  v1::Recipe recipe = MakeRecipe();
  recipe.mutable_evaluation()->set_interval(0);
  EXPECT_THAT(CheckReplayHolds(recipe, MakeLayout(), 7, 1),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("of 6 environments may need, found 1")));
}

}  // namespace
}  // namespace sinew::learner
