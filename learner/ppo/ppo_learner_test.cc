#include "learner/ppo/ppo_learner.h"

#include <cmath>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "common/policy/safetensors.h"
#include "common/segment/mirror.h"
#include "common/segment/segment_layout.h"
#include "common/testing/matchers.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "learner/ppo/synthetic_segments.h"
#include "learner/ppo/testing/ppo_rig.h"
#include "learner/update/normaliser.h"

namespace sinew::learner {
namespace {

using ::sinew::testing::IsOk;
using ::sinew::testing::StatusIs;
using ::testing::HasSubstr;

// Overwrites element `index` of a float32 column.
void Poke(v1::Segment& segment, absl::string_view name, size_t index,
          float value) {
  v1::Tensor* column = FindColumn(segment, name);
  ASSERT_NE(column, nullptr) << name;
  column->mutable_data()->replace(index * sizeof(float), sizeof(float),
                                  reinterpret_cast<const char*>(&value),
                                  sizeof(float));
}

TEST(PpoLearner, SolvesASyntheticProblem) {
  const auto learner = MakeLearner(MakeRecipe());
  const double error_before = MeanActionError(Collect(*learner, 1000));
  UpdateStatistics first, last;

  for (int64_t i = 0; i < 60; ++i) {
    last = UpdateOnce(*learner, i);
    if (i == 0) first = last;
  }

  const double error_after = MeanActionError(Collect(*learner, 1000));
  EXPECT_GT(error_before, 0.2);
  EXPECT_LT(error_after, 0.02);
  // The best possible mean is that of exp(-|0.3 z|^2 / 2) over 3 actions:
  // (1 + 0.09)^-1.5 = 0.879.
  EXPECT_LT(first.reward_mean, 0.7);
  EXPECT_GT(last.reward_mean, 0.84);
  EXPECT_LT(last.reward_mean, 0.9);
  EXPECT_EQ(last.samples, 2048);
  EXPECT_EQ(last.non_finite, 0);
}

TEST(PpoLearner, RanksDoNotChangeABit) {
  const auto one = MakeLearner(MakeRecipe(), /*ranks=*/1);
  const auto two = MakeLearner(MakeRecipe(), /*ranks=*/2);
  const auto three = MakeLearner(MakeRecipe(), /*ranks=*/3);

  for (int64_t i = 0; i < 3; ++i) {
    UpdateOnce(*one, i);
    UpdateOnce(*two, i);
    UpdateOnce(*three, i);
  }

  EXPECT_EQ(Bits(*one), Bits(*two));
  EXPECT_EQ(Bits(*one), Bits(*three));
}

TEST(PpoLearner, ShardsChangeResultsInTheLastBitsOnly) {
  const auto one = MakeLearner(MakeRecipe("ppo { shards: 1 }"));
  const auto four = MakeLearner(MakeRecipe("ppo { shards: 4 }"));

  UpdateOnce(*one, 0);
  UpdateOnce(*four, 0);

  const TensorMap a = one->weights(), b = four->weights();
  for (const auto& [name, tensor] : a) {
    for (int64_t i = 0; i < tensor.num_elements(); ++i) {
      // 12 steps of Adam of up to 3e-3 each.
      ASSERT_NEAR(tensor.float32()[i], b.at(name).float32()[i], 2e-3) << name;
    }
  }
}

TEST(PpoLearner, StopsItsEpochsOnceKlIsTooLarge) {
  const std::string eager =
      "ppo { epochs: 6 policy_learning_rate: 0.03 kl_stop: ";
  const auto stopped = MakeLearner(MakeRecipe(eager + "0.02 }"));
  const auto free = MakeLearner(MakeRecipe(eager + "1e9 }"));

  const UpdateStatistics with_stop = UpdateOnce(*stopped, 0);
  const UpdateStatistics without = UpdateOnce(*free, 0);

  EXPECT_LT(with_stop.epochs, 6);
  EXPECT_GE(with_stop.epochs, 1);
  EXPECT_GT(with_stop.kl, 0.02);
  EXPECT_EQ(without.epochs, 6);
  // 4 minibatches an epoch, no step after the stop.
  v1::TrainingState state;
  stopped->SaveCounters(state);
  EXPECT_EQ(state.policy_optimiser_step(), 4 * with_stop.epochs);
}

TEST(PpoLearner, ReportsNoKlBeforeItHasLearned) {
  // With a vanishing rate the policy stays what has acted: KL and clip
  // fraction are 0 up to the difference of the two back ends.
  const auto learner =
      MakeLearner(MakeRecipe("ppo { policy_learning_rate: 1e-12 epochs: 1 }"));

  const UpdateStatistics statistics = UpdateOnce(*learner, 0);

  EXPECT_NEAR(statistics.kl, 0, 1e-8);
  EXPECT_EQ(statistics.clip_fraction, 0);
  // Entropy of 3 Gaussians: 3 (ln 0.3 + (1 + ln 2 pi) / 2) = 0.6449.
  EXPECT_NEAR(statistics.entropy, 0.6449, 1e-3);
}

// Of the synthetic problem: it has no sides, so any will do.
SegmentMirror MakeMirror() {
  return {.observation = {{1, 0, 2, 4, 3, 5}, {1, 1, -1, -1, -1, 1}},
          .action = {{1, 0, 2}, {1, 1, -1}}};
}

TEST(PpoLearner, LearnsFromMirrorImagesToo) {
  const std::string vanishing = "ppo { policy_learning_rate: 1e-12 epochs: 1 ";
  const v1::Recipe recipe = MakeRecipe(vanishing + "mirror: true }");
  const auto learner = MakeLearner(recipe, 2, MakeMirror());
  const auto plain = MakeLearner(MakeRecipe(vanishing + "}"));

  const UpdateStatistics images = UpdateOnce(*learner, 0);
  const UpdateStatistics without = UpdateOnce(*plain, 0);

  EXPECT_EQ(images.samples, without.samples);
  EXPECT_EQ(images.reward_mean, without.reward_mean);
  v1::TrainingState state, plain_state;
  learner->SaveCounters(state);
  plain->SaveCounters(plain_state);
  EXPECT_EQ(state.value_optimiser_step(),
            2 * plain_state.value_optimiser_step());
  EXPECT_EQ(state.normaliser_count(), 2 * plain_state.normaliser_count());
  // The policy has not moved. That its mean is another one on the other side is
  // not counted as movement, or the KL stop would end the passes for it.
  EXPECT_NEAR(images.kl, 0, 1e-8);
  EXPECT_EQ(images.clip_fraction, 0);
}

TEST(PpoLearner, MeasuresMovementAlsoWithMirrorImages) {
  const std::string eager = "ppo { policy_learning_rate: 0.03 kl_stop: 1e9 ";
  const auto learner =
      MakeLearner(MakeRecipe(eager + "mirror: true }"), 2, MakeMirror());

  const UpdateStatistics statistics = UpdateOnce(*learner, 0);

  EXPECT_GT(statistics.kl, 0.02);
  EXPECT_GT(statistics.clip_fraction, 0.02);
}

TEST(PpoLearner, NeedsAMirrorForImages) {
  EXPECT_THAT(PpoLearner::Create(
                  MakeRecipe("ppo { mirror: true }"),
                  {.observation_width = 6, .action_width = 3, .ranks = 1})
                  .status(),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("recipe field ppo.mirror")));
}

TEST(PpoLearner, AdaptsThePolicyLearningRateToKl) {
  const auto fast = MakeLearner(MakeRecipe("ppo { kl_target: 1e-6 }"));
  const auto slow = MakeLearner(MakeRecipe("ppo { kl_target: 1e3 }"));

  for (int64_t i = 0; i < 2; ++i) {
    UpdateOnce(*fast, i);
    UpdateOnce(*slow, i);
  }

  EXPECT_NEAR(UpdateOnce(*fast, 2).policy_learning_rate, 3e-3 / 2.25, 1e-9);
  EXPECT_NEAR(UpdateOnce(*slow, 2).policy_learning_rate, 3e-3 * 2.25, 1e-9);
  for (int64_t i = 3; i < 12; ++i) UpdateOnce(*slow, i);
  const UpdateStatistics last = UpdateOnce(*slow, 12);
  EXPECT_NEAR(last.policy_learning_rate, 3e-3 * 4, 1e-9);
  EXPECT_NEAR(last.value_learning_rate, 3e-3, 1e-9);
}

TEST(PpoLearner, BeginsAtTheLeastRateWithWhatHasLearnt) {
  const auto learnt = MakeLearner(MakeRecipe());
  const auto first_rate = [&](const std::string& ppo) {
    const auto learner = MakeLearner(MakeRecipe(ppo));
    EXPECT_THAT(learner->InitFrom(learnt->weights()), IsOk());
    return UpdateOnce(*learner, 0).policy_learning_rate;
  };

  EXPECT_NEAR(first_rate("ppo { kl_target: 0.01 }"), 3e-4, 1e-9);
  EXPECT_NEAR(first_rate(""), 3e-3, 1e-9);
}

TEST(PpoLearner, TheValueNetworkLearnsAloneAtFirst) {
  const auto learner = MakeLearner(
      MakeRecipe("ppo { value_warmup_iterations: 2 kl_target: 1e3 }"));
  const TensorMap before = learner->weights();
  const auto changed = [&](const std::string& part) {
    int tensors = 0;
    const TensorMap now = learner->weights();
    for (const auto& [name, tensor] : before) {
      if (!name.starts_with(part)) continue;
      tensors += now.at(name).float32() != tensor.float32();
    }
    return tensors;
  };

  UpdateOnce(*learner, 0);
  const UpdateStatistics last = UpdateOnce(*learner, 1);

  EXPECT_EQ(changed("policy/"), 0);
  EXPECT_EQ(changed("normaliser/"), 0);
  EXPECT_GT(changed("critic/"), 0);
  EXPECT_EQ(last.epochs, 3);
  EXPECT_EQ(last.policy_loss, 0);
  EXPECT_EQ(last.policy_gradient_norm, 0);
  EXPECT_EQ(last.kl, 0);
  EXPECT_GT(last.value_loss, 0);
  EXPECT_GT(last.value_gradient_norm, 0);
  EXPECT_EQ(last.policy_learning_rate, 0);
  v1::TrainingState state;
  learner->SaveCounters(state);
  EXPECT_EQ(state.policy_optimiser_step(), 0);
  EXPECT_EQ(state.value_optimiser_step(), 2 * 3 * 4);

  const UpdateStatistics first = UpdateOnce(*learner, 2);
  EXPECT_GT(first.policy_gradient_norm, 0);
  // There was nothing to adapt it to.
  EXPECT_NEAR(first.policy_learning_rate, 3e-3, 1e-9);
  EXPECT_GT(changed("policy/"), 0);
  EXPECT_GT(changed("normaliser/"), 0);
}

TEST(PpoLearner, GoesOnAfterALoadAmidTheWarmup) {
  const v1::Recipe recipe = MakeRecipe("ppo { value_warmup_iterations: 2 }");
  const auto learner = MakeLearner(recipe);
  UpdateOnce(*learner, 0);
  v1::TrainingState state;
  learner->SaveCounters(state);
  const auto resumed = MakeLearner(recipe, /*ranks=*/1);

  ASSERT_THAT(resumed->Load(learner->SaveTensors(), state, {}), IsOk());

  for (int64_t i = 1; i < 4; ++i) {
    UpdateOnce(*learner, i);
    UpdateOnce(*resumed, i);
    EXPECT_EQ(Bits(*resumed), Bits(*learner)) << i;
  }
}

TEST(PpoLearner, SkipsAndCountsMinibatchesWithNonFiniteLoss) {
  const auto learner = MakeLearner(MakeRecipe("ppo { epochs: 2 }"));
  std::vector<v1::Segment> segments = Collect(*learner, 0);
  Poke(segments[3], column::kAction, 5,
       std::numeric_limits<float>::quiet_NaN());

  const auto statistics = learner->Update(Pointers(segments), 0);

  ASSERT_THAT(statistics.status(), IsOk());
  EXPECT_EQ(statistics->non_finite, 2);  // the row's minibatch in each epoch
  EXPECT_TRUE(std::isfinite(statistics->policy_loss));
  EXPECT_THAT(CheckFinite(learner->SaveTensors(), "learner"), IsOk());
  v1::TrainingState state;
  learner->SaveCounters(state);
  EXPECT_EQ(state.policy_optimiser_step(), 2 * 4 - 2);
}

TEST(PpoLearner, InvalidRowsHaveNoEffect) {
  const SyntheticProblem problem = {.invalid_share = 0.1};
  const auto learner = MakeLearner(MakeRecipe());
  const auto other = MakeLearner(MakeRecipe());
  std::vector<v1::Segment> segments = Collect(*learner, 0, problem);
  std::vector<v1::Segment> altered = segments;
  int64_t invalid = 0;
  for (v1::Segment& segment : altered) {
    const std::string valid = FindColumn(segment, column::kValid)->data();
    for (size_t row = 0; row < valid.size(); ++row) {
      if (valid[row] != 0) continue;
      ++invalid;
      Poke(segment, column::kAction, row * 3, 77);
      Poke(segment, column::kActionMean, row * 3, -5);
      Poke(segment, column::kLogProbability, row, 1);
      Poke(segment, column::kBodyDistance, row, 9);
    }
  }

  const auto a = learner->Update(Pointers(segments), 0);
  const auto b = other->Update(Pointers(altered), 0);

  ASSERT_THAT(a.status(), IsOk());
  ASSERT_THAT(b.status(), IsOk());
  EXPECT_GT(invalid, 100);
  EXPECT_EQ(a->samples, 2048 - invalid);
  EXPECT_EQ(a->body_distance_mean_m, b->body_distance_mean_m);
  v1::TrainingState state;
  learner->SaveCounters(state);
  EXPECT_EQ(state.normaliser_count(), 2048 - invalid);
  EXPECT_EQ(Bits(*learner), Bits(*other));
}

TEST(PpoLearner, NormaliserLearnsTheObservationsAfterTheUpdate) {
  const auto learner = MakeLearner(MakeRecipe());
  TensorMap weights = learner->weights();
  for (const float mean : weights.at("normaliser/mean").float32()) {
    EXPECT_EQ(mean, 0);
  }

  UpdateOnce(*learner, 0);

  weights = learner->weights();
  // 2048 rows of N(3, 2^2).
  for (const float mean : weights.at("normaliser/mean").float32()) {
    EXPECT_NEAR(mean, 3, 0.2);
  }
  for (const float inverse : weights.at("normaliser/inverse_std").float32()) {
    EXPECT_NEAR(inverse, 0.5, 0.03);
  }
  v1::TrainingState state;
  learner->SaveCounters(state);
  EXPECT_EQ(state.normaliser_count(), 2048);
}

// One that is taken over gives way to 2048 rows of N(3, 2^2) by what it counts.
TEST(PpoLearner, InheritedNormaliserCountsAsManyRowsAsTheRecipeSays) {
  const auto mean_after = [](double inherited_rows) {
    v1::Recipe recipe = MakeRecipe();
    recipe.mutable_ppo()->set_inherited_rows(inherited_rows);
    const auto learner = MakeLearner(recipe);
    EXPECT_THAT(learner->InitFrom(MakeLearner(MakeRecipe())->weights()),
                IsOk());
    UpdateOnce(*learner, 0);
    return double{learner->weights().at("normaliser/mean").float32()[0]};
  };

  EXPECT_NEAR(mean_after(2048), 1.5, 0.1);
  EXPECT_NEAR(mean_after(0), 3 * 2048 / (2048 + kInheritedRows), 0.01);
  EXPECT_NEAR(mean_after(1e12), 0, 1e-7);
}

TEST(PpoLearner, FactorsChangeNoiseAndRates) {
  const auto learner = MakeLearner(MakeRecipe());

  learner->SetFactors(/*std_factor=*/0.5, /*learning_rate_factor=*/0.1);
  const UpdateStatistics statistics = UpdateOnce(*learner, 0);

  const TensorMap weights = learner->weights();
  for (const float std : weights.at("policy/std").float32()) {
    EXPECT_FLOAT_EQ(std, 0.15f);
  }
  EXPECT_NEAR(statistics.policy_learning_rate, 3e-4, 1e-9);
  EXPECT_NEAR(statistics.value_learning_rate, 3e-4, 1e-9);
  EXPECT_EQ(statistics.std_factor, 0.5);
}

TEST(PpoLearner, CountsTheFlopsOfItsProducts) {
  const auto learner =
      MakeLearner(MakeRecipe("ppo { epochs: 1 kl_stop: 1e9 }"));
  const SyntheticProblem problem = {.truncated_share = 0};

  const UpdateStatistics statistics = UpdateOnce(*learner, 0, problem);

  // Multiply-adds a row: policy 6*32 + 32*32 + 32*3 = 1312, critic
  // 6*32 + 32*32 + 32 = 1248; backwards twice that but once for the first
  // layer (192): 2432 and 2304.
  const double per_row = 2.0 * (1312 + 2432 + 1248 + 2304);
  const double values = 2.0 * 1248 * (2048 + 64);  // 8 x 8 boundary rows
  const double kl = 2.0 * 1312 * 512;
  EXPECT_EQ(statistics.flops, 2048 * per_row + values + kl);
}

}  // namespace
}  // namespace sinew::learner
