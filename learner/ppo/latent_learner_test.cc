// A latent that PPO learns from rewards alone.

#include <cstdint>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "absl/strings/string_view.h"
#include "common/policy/safetensors.h"
#include "common/segment/segment_layout.h"
#include "common/testing/matchers.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "learner/ppo/ppo_learner.h"
#include "learner/ppo/synthetic_segments.h"
#include "learner/ppo/testing/latent_kl.h"
#include "learner/ppo/testing/ppo_rig.h"
#include "learner/update/segment_view.h"

namespace sinew::learner {
namespace {

using ::sinew::testing::IsOk;
using ::sinew::testing::StatusIs;
using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

constexpr SyntheticProblem kProblem = {.latent_width = 3};

v1::Recipe LatentRecipe(const std::string& overrides = "") {
  return MakeRecipe(
      R"pb(
        task { action { placement: PLACEMENT_ABSOLUTE } }
        network {
          latent {
            width: 3
            encoder_hidden: 32
            prior_hidden: 16
            decoder_hidden: 32
          }
        }
        ppo { latent_kl_weight: 1e-4 }
      )pb" +
      overrides);
}

// So many updates; the statistics of the last.
UpdateStatistics UpdateUntil(PpoLearner& learner, int64_t iterations,
                             int64_t first = 0) {
  UpdateStatistics last;
  for (int64_t i = first; i < iterations; ++i) {
    last = UpdateOnce(learner, i, kProblem);
  }
  return last;
}

// Adds to every number of a float32 column.
void Shift(v1::Segment& segment, absl::string_view name, float by) {
  v1::Tensor* column = FindColumn(segment, name);
  ASSERT_NE(column, nullptr) << name;
  auto* values = reinterpret_cast<float*>(column->mutable_data()->data());
  for (size_t i = 0; i < column->data().size() / sizeof(float); ++i) {
    values[i] += by;
  }
}

TEST(LatentLearner, StaysAsItIsWhileTheValueNetworkWarmsUp) {
  const auto learner =
      MakeLearner(LatentRecipe("ppo { value_warmup_iterations: 2 }"));
  const TensorMap before = learner->weights();

  const UpdateStatistics last = UpdateUntil(*learner, 2);

  EXPECT_FALSE(last.latent_kl.has_value());
  for (const auto& [name, tensor] : learner->weights()) {
    EXPECT_EQ(tensor.float32() != before.at(name).float32(),
              name.starts_with("critic/"))
        << name;
  }
  EXPECT_TRUE(UpdateOnce(*learner, 2, kProblem).latent_kl.has_value());
}

TEST(LatentLearner, LearnsASyntheticProblem) {
  const auto learner = MakeLearner(LatentRecipe());
  const double before = MeanActionError(Collect(*learner, 1000, kProblem));
  const UpdateStatistics first = UpdateOnce(*learner, 0, kProblem);

  const UpdateStatistics last = UpdateUntil(*learner, 60, /*first=*/1);

  EXPECT_GT(before, 0.2);
  EXPECT_LT(MeanActionError(Collect(*learner, 1000, kProblem)), 0.7 * before);
  EXPECT_GT(last.reward_mean, first.reward_mean);
  EXPECT_EQ(last.samples, 2048);
  EXPECT_EQ(last.non_finite, 0);
  ASSERT_TRUE(last.latent_kl.has_value());
  EXPECT_GT(*last.latent_kl, 0);
  EXPECT_THAT(CheckFinite(learner->SaveTensors(), "learner"), IsOk());
}

TEST(LatentLearner, BeginsWithThePolicyThatHasActed) {
  // With a vanishing rate it stays that: ratios are 1 up to the difference of
  // the two back ends, given the noise of the latent.
  const auto learner = MakeLearner(
      LatentRecipe("network { last_layer_gain: 1 }"
                   "ppo { policy_learning_rate: 1e-12 epochs: 1 }"));

  const UpdateStatistics statistics = UpdateOnce(*learner, 0, kProblem);

  EXPECT_NEAR(statistics.kl, 0, 1e-7);
  EXPECT_EQ(statistics.clip_fraction, 0);
  // Of the action alone: 3 (ln 0.3 + (1 + ln 2 pi) / 2) = 0.6449.
  EXPECT_NEAR(statistics.entropy, 0.6449, 1e-3);
}

// Mean over steps of KL(posterior || prior).
double MeanLatentKl(const PpoLearner& learner,
                    const std::vector<v1::Segment>& segments) {
  constexpr size_t kWidth = kProblem.observation_width;
  double sum = 0;
  size_t rows = 0;
  for (const v1::Segment& segment : segments) {
    // The body's own state is all but two columns (MakeLearner).
    for (const double kl :
         LatentKl(learner.graph(), learner.weights(),
                  ColumnOf<float>(segment, column::kObservation), kWidth,
                  kWidth - 2)) {
      sum += kl;
      ++rows;
    }
  }
  return sum / static_cast<double>(rows);
}

TEST(LatentLearner, TheKlIsThatOfAStepInTheMean) {
  // The normaliser that acted is the one that the update uses.
  const auto learner = MakeLearner(
      LatentRecipe("network { last_layer_gain: 1 }"
                   "ppo { policy_learning_rate: 1e-12 epochs: 2 }"));
  const std::vector<v1::Segment> segments = Collect(*learner, 0, kProblem);
  const double expected = MeanLatentKl(*learner, segments);

  const auto statistics = learner->Update(Pointers(segments), 0);

  ASSERT_THAT(statistics, IsOk());
  EXPECT_GT(expected, 1e-3);
  EXPECT_NEAR(*statistics->latent_kl, expected, 1e-3 * expected);
}

TEST(LatentLearner, NeedsTheNoiseThatHasActed) {
  const auto learner = MakeLearner(
      LatentRecipe("network { last_layer_gain: 1 }"
                   "ppo { policy_learning_rate: 1e-12 epochs: 1 }"));
  std::vector<v1::Segment> segments = Collect(*learner, 0, kProblem);
  for (v1::Segment& segment : segments) Shift(segment, "latent_noise", 1);

  const auto statistics = learner->Update(Pointers(segments), 0);

  ASSERT_THAT(statistics, IsOk());
  EXPECT_GT(statistics->kl, 0.01);
  EXPECT_GT(statistics->clip_fraction, 0);
}

TEST(LatentLearner, AHeavyWeightBringsThePosteriorToThePrior) {
  const std::string eager =
      "network { last_layer_gain: 1 } ppo { kl_stop: 1e9 ";
  const auto free = MakeLearner(LatentRecipe(eager + "latent_kl_weight: 0 }"));
  const auto heavy =
      MakeLearner(LatentRecipe(eager + "latent_kl_weight: 10 }"));
  const UpdateStatistics first = UpdateOnce(*heavy, 0, kProblem);
  UpdateOnce(*free, 0, kProblem);

  const UpdateStatistics of_heavy = UpdateUntil(*heavy, 30, /*first=*/1);
  const UpdateStatistics of_free = UpdateUntil(*free, 30, /*first=*/1);

  EXPECT_LT(*of_heavy.latent_kl, *first.latent_kl);
  EXPECT_LT(*of_heavy.latent_kl, 0.25 * *of_free.latent_kl);
}

TEST(LatentLearner, OtherPoliciesHaveNoLatentKl) {
  const auto learner = MakeLearner(MakeRecipe());

  EXPECT_FALSE(UpdateOnce(*learner, 0).latent_kl.has_value());
}

TEST(LatentLearner, RanksDoNotChangeABit) {
  const auto one = MakeLearner(LatentRecipe(), /*ranks=*/1);
  const auto three = MakeLearner(LatentRecipe(), /*ranks=*/3);

  UpdateUntil(*one, 3);
  UpdateUntil(*three, 3);

  EXPECT_EQ(Bits(*one), Bits(*three));
}

TEST(LatentLearner, SavedLoadedAndUpdatedGivesTheSameBits) {
  const v1::Recipe recipe = LatentRecipe("ppo { kl_target: 0.01 }");
  const auto learner = MakeLearner(recipe);
  learner->SetFactors(0.8, 0.7);
  UpdateUntil(*learner, 4);
  const TensorMap tensors = learner->SaveTensors();
  v1::TrainingState state;
  learner->SaveCounters(state);
  UpdateUntil(*learner, 6, /*first=*/4);

  const auto resumed = MakeLearner(recipe, /*ranks=*/1);
  ASSERT_THAT(resumed->Load(tensors, state, /*chunks=*/{}), IsOk());
  UpdateUntil(*resumed, 6, /*first=*/4);

  EXPECT_EQ(Bits(*resumed), Bits(*learner));
}

TEST(LatentLearner, TrainsAllOfItsNetworksButWhatIsFrozen) {
  const auto learner = MakeLearner(LatentRecipe());
  const TensorMap before = learner->weights();

  UpdateUntil(*learner, 2);

  const TensorMap after = learner->SaveTensors();
  for (const char* name : {"encoder/mean/weight", "encoder/log_variance/weight",
                           "prior/mean/weight", "prior/log_variance/weight",
                           "decoder/action/weight", "critic/value/weight"}) {
    EXPECT_NE(after.at(name).data, before.at(name).data) << name;
    EXPECT_TRUE(after.contains(std::string("adam/first_moment/").append(name)));
  }
  for (const char* name : {"policy/std", "latent/half"}) {
    EXPECT_EQ(after.at(name).data, before.at(name).data) << name;
  }
  // 4096 rows of N(3, 2^2), 4 columns and 2.
  ASSERT_EQ(after.at("normaliser/own/mean").num_elements(), 4);
  ASSERT_EQ(after.at("normaliser/goal/mean").num_elements(), 2);
  for (const char* name : {"normaliser/own/mean", "normaliser/goal/mean"}) {
    for (const float mean : after.at(name).float32()) {
      EXPECT_NEAR(mean, 3, 0.2) << name;
    }
  }
}

TEST(LatentLearner, StartsFromAnotherRunsWeights) {
  const auto trained = MakeLearner(LatentRecipe());
  UpdateUntil(*trained, 5);
  TensorMap bundle = trained->weights();
  std::erase_if(
      bundle, [](const auto& one) { return one.first.starts_with("critic"); });
  const auto learner = MakeLearner(LatentRecipe());

  ASSERT_THAT(learner->InitFrom(bundle), IsOk());

  EXPECT_NEAR(MeanActionError(Collect(*learner, 1000, kProblem)),
              MeanActionError(Collect(*trained, 1000, kProblem)), 1e-9);
  UpdateOnce(*learner, 0, kProblem);
  // The normaliser goes on from the bundle's.
  EXPECT_NEAR(learner->weights().at("normaliser/goal/mean").float32()[1],
              bundle.at("normaliser/goal/mean").float32()[1], 5e-3);
}

TEST(LatentLearner, HasTheGraphsOfAStudentAndACritic) {
  const auto learner = MakeLearner(LatentRecipe());
  std::set<std::string> names;
  for (const v1::Graph& graph : learner->graph().graphs()) {
    names.insert(graph.name());
  }

  EXPECT_THAT(names, ElementsAre("critic", "decoder", "encoder", "policy",
                                 "prior", "sample"));
}

TEST(LatentLearner, RefusesSegmentsWithoutTheNoise) {
  const auto learner = MakeLearner(LatentRecipe());
  const std::string before = Bits(*learner);
  std::vector<v1::Segment> segments = Collect(*learner, 0, kProblem);
  auto& columns = *segments[1].mutable_columns();
  for (int i = 0; i < columns.size(); ++i) {
    if (columns[i].name() != "latent_noise") continue;
    columns.DeleteSubrange(i, 1);
    break;
  }

  EXPECT_THAT(learner->Update(Pointers(segments), 0).status(),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       AllOf(HasSubstr("order 1"), HasSubstr("columns"))));
  EXPECT_EQ(Bits(*learner), before);
}

TEST(LatentLearner, NeedsColumnsOfTheBodysOwnState) {
  EXPECT_THAT(
      PpoLearner::Create(LatentRecipe(),
                         {.observation_width = 6, .action_width = 3})
          .status(),
      StatusIs(absl::StatusCode::kInvalidArgument,
               HasSubstr("self_observation_width: expected >= 1, found 0")));
}

}  // namespace
}  // namespace sinew::learner
