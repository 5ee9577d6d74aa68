#include "learner/update/running_state.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/policy/safetensors.h"
#include "common/testing/matchers.h"

namespace sinew::learner {
namespace {

using ::sinew::testing::IsOk;
using ::sinew::testing::StatusIs;
using ::testing::ElementsAre;

TensorMap Saved() {
  RunningState state;
  state.moments.count = 8;
  state.moments.mean = {1, 2};
  state.moments.squares = {3, 4};
  state.std_factor = 0.5;
  state.learning_rate_factor = 0.25;
  TensorMap tensors;
  SaveRunningState(state, tensors);
  return tensors;
}

TEST(RunningState, ComesBackAsItWasSaved) {
  const auto state = LoadRunningState(Saved(), /*width=*/2, /*count=*/8);

  ASSERT_THAT(state.status(), IsOk());
  EXPECT_EQ(state->moments.count, 8);
  EXPECT_THAT(state->moments.mean, ElementsAre(1, 2));
  EXPECT_THAT(state->moments.squares, ElementsAre(3, 4));
  EXPECT_EQ(state->std_factor, 0.5);
  EXPECT_EQ(state->learning_rate_factor, 0.25);
}

TEST(RunningState, IsRefusedByNameOfTensor) {
  TensorMap lacks = Saved();
  lacks.erase("factors");

  EXPECT_THAT(LoadRunningState(lacks, 2, 8).status(),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       "training state: tensor factors: expected float64 [2], "
                       "found none"));
  EXPECT_THAT(LoadRunningState(Saved(), /*width=*/3, 8).status(),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       "training state: tensor normaliser_sums/mean: expected "
                       "float64 [3], found DATA_TYPE_FLOAT64 [2]"));
}

}  // namespace
}  // namespace sinew::learner
