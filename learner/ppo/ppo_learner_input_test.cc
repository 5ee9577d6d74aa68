// What comes to the learner from outside: states, weights, segments, machines.

#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "common/policy/safetensors.h"
#include "common/testing/matchers.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "learner/ppo/ppo_learner.h"
#include "learner/ppo/synthetic_segments.h"
#include "learner/ppo/testing/ppo_rig.h"
#include "learner/torch/runtime.h"

namespace sinew::learner {
namespace {

using ::sinew::testing::IsOk;
using ::sinew::testing::StatusIs;
using ::testing::AllOf;
using ::testing::HasSubstr;

TEST(PpoLearner, SavedLoadedAndUpdatedGivesTheSameBits) {
  const v1::Recipe recipe = MakeRecipe("ppo { kl_target: 0.01 }");
  const auto learner = MakeLearner(recipe);
  learner->SetFactors(0.8, 0.7);
  for (int64_t i = 0; i < 4; ++i) UpdateOnce(*learner, i);
  const TensorMap tensors = learner->SaveTensors();
  v1::TrainingState state;
  learner->SaveCounters(state);
  for (int64_t i = 4; i < 6; ++i) UpdateOnce(*learner, i);

  const auto resumed = MakeLearner(recipe, /*ranks=*/1);
  ASSERT_THAT(resumed->Load(tensors, state, /*chunks=*/{}), IsOk());
  for (int64_t i = 4; i < 6; ++i) UpdateOnce(*resumed, i);

  EXPECT_EQ(Bits(*resumed), Bits(*learner));
}

TEST(PpoLearner, StartsFromAnotherRunsWeights) {
  const auto trained = MakeLearner(MakeRecipe());
  for (int64_t i = 0; i < 20; ++i) UpdateOnce(*trained, i);
  trained->SetFactors(0.5, 1);
  TensorMap bundle = trained->weights();
  std::erase_if(
      bundle, [](const auto& one) { return one.first.starts_with("critic"); });
  const auto learner = MakeLearner(MakeRecipe());

  ASSERT_THAT(learner->InitFrom(bundle), IsOk());

  EXPECT_NEAR(MeanActionError(Collect(*learner, 1000)),
              MeanActionError(Collect(*trained, 1000)), 1e-9);
  // Exploration is the recipe's own; the normaliser goes on from the bundle's.
  EXPECT_FLOAT_EQ(learner->weights().at("policy/std").float32()[0], 0.3f);
  UpdateOnce(*learner, 0);
  EXPECT_NEAR(learner->weights().at("normaliser/mean").float32()[0],
              bundle.at("normaliser/mean").float32()[0], 5e-3);
}

TEST(PpoLearner, StartsFromANarrowerNetworkAsItsEqual) {
  const auto trained = MakeLearner(MakeRecipe());
  for (int64_t i = 0; i < 20; ++i) UpdateOnce(*trained, i);
  v1::Recipe recipe = MakeRecipe();
  for (int i = 0; i < 2; ++i) {
    recipe.mutable_network()->set_policy_hidden(i, 48 + 8 * i);
    recipe.mutable_network()->set_value_hidden(i, 40);
  }
  const auto learner = MakeLearner(recipe);

  ASSERT_THAT(learner->InitFrom(trained->weights()), IsOk());

  const double before = MeanActionError(Collect(*trained, 1000));
  EXPECT_NEAR(MeanActionError(Collect(*learner, 1000)), before, 1e-6);
  // New units learn.
  const TensorMap start = learner->weights();
  UpdateOnce(*learner, 0);
  const HostTensor first = start.at("policy/mean/weight");
  const HostTensor then = learner->weights().at("policy/mean/weight");
  const int64_t last = first.shape[1] - 1;
  EXPECT_EQ(first.float32()[last], 0);
  EXPECT_GT(std::abs(then.float32()[last]), 1e-5);
}

TEST(PpoLearner, RefusesWeightsOfOtherNetworks) {
  const auto learner = MakeLearner(MakeRecipe());
  const std::string before = Bits(*learner);
  const TensorMap wide = {
      {"policy/linear_0/weight", HostTensor::Zeros({64, 6})}};

  EXPECT_THAT(learner->InitFrom(wide),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       AllOf(HasSubstr("policy/linear_0/weight"),
                             HasSubstr("expected shape [32, 6]"),
                             HasSubstr("found shape [64, 6]"))));
  EXPECT_THAT(learner->InitFrom({{"other", HostTensor::Zeros({1})}}),
              StatusIs(absl::StatusCode::kInvalidArgument));
  EXPECT_EQ(Bits(*learner), before);
}

TEST(PpoLearner, RefusesSegmentsThatDoNotFit) {
  const auto learner = MakeLearner(MakeRecipe());
  const std::string before = Bits(*learner);
  std::vector<v1::Segment> segments = Collect(*learner, 0);
  segments[2].mutable_columns(0)->set_shape(2, 7);

  EXPECT_THAT(learner->Update(Pointers(segments), 0).status(),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       AllOf(HasSubstr("order 2"), HasSubstr("observation"))));
  segments = Collect(*learner, 0);
  segments[1].mutable_columns()->DeleteSubrange(1, 1);
  EXPECT_THAT(
      learner->Update(Pointers(segments), 0).status(),
      StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr("order 1")));
  segments = Collect(*learner, 0);
  segments.pop_back();
  EXPECT_THAT(
      learner->Update(Pointers(segments), 0).status(),
      StatusIs(absl::StatusCode::kInvalidArgument,
               AllOf(HasSubstr("ppo.minibatch = 512"), HasSubstr("1792"))));
  EXPECT_THAT(learner->Update({}, 0).status(),
              StatusIs(absl::StatusCode::kInvalidArgument));
  EXPECT_EQ(Bits(*learner), before);
}

TEST(PpoLearner, RefusesADamagedTrainingState) {
  const auto learner = MakeLearner(MakeRecipe());
  UpdateOnce(*learner, 0);
  const TensorMap tensors = learner->SaveTensors();
  v1::TrainingState state;
  learner->SaveCounters(state);
  // What is loaded in part shows only in a learner that has gone on.
  UpdateOnce(*learner, 1);
  const std::string before = Bits(*learner);

  for (const auto& [name, tensor] : tensors) {
    TensorMap damaged = tensors;
    damaged.erase(name);
    EXPECT_THAT(learner->Load(damaged, state, /*chunks=*/{}),
                StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr(name)));
    EXPECT_EQ(Bits(*learner), before) << name;
  }
  TensorMap damaged = tensors;
  damaged.at("policy/mean/bias").mutable_float32()[0] = NAN;
  EXPECT_THAT(learner->Load(damaged, state, /*chunks=*/{}),
              StatusIs(absl::StatusCode::kInvalidArgument));
  state.set_learning_rate_factor(-1);
  EXPECT_THAT(learner->Load(tensors, state, /*chunks=*/{}),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("learning_rate_factor")));
  EXPECT_EQ(Bits(*learner), before);
}

TEST(PpoLearner, RefusesWhatTheMachineLacks) {
  const PpoLearner::Options options = {.observation_width = 6,
                                       .action_width = 3};
  const CpuFeatures cpu = DetectCpu();
  if (!cpu.avx512_bf16 && !cpu.amx_bf16) {
    EXPECT_THAT(
        PpoLearner::Create(MakeRecipe("ppo { bfloat16: true }"), options)
            .status(),
        StatusIs(absl::StatusCode::kFailedPrecondition,
                 HasSubstr("ppo.bfloat16")));
  }
  if (!CheckDevice("cuda").ok()) {
    EXPECT_THAT(
        PpoLearner::Create(MakeRecipe("device: \"cuda\""), options).status(),
        StatusIs(absl::StatusCode::kFailedPrecondition,
                 HasSubstr("asked for \"cuda\"")));
  }
  EXPECT_THAT(
      PpoLearner::Create(
          MakeRecipe(), {.observation_width = 6, .action_width = 3, .ranks = 0})
          .status(),
      StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr("ranks")));
}

}  // namespace
}  // namespace sinew::learner
