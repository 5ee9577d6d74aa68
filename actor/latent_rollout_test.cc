// Rollouts of recipes in which PPO learns a latent: its noise beside that of
// the action.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <set>
#include <string>
#include <vector>

#include "absl/types/span.h"
#include "actor/prepared_snapshot.h"
#include "actor/rollout.h"
#include "actor/testing/order_allocations.h"
#include "actor/testing/rollout_rig.h"
#include "common/config/recipe.h"
#include "common/digest.h"
#include "common/policy/executor.h"
#include "common/policy/safetensors.h"
#include "common/random/philox.h"
#include "common/segment/segment_layout.h"
#include "common/testing/matchers.h"

namespace sinew::actor {
namespace {

using ::sinew::testing::IsOk;
using ::sinew::testing::StatusIs;
using testing::Column;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using testing::RolloutRig;
using ::testing::SizeIs;

constexpr int kJoints = 4, kLatent = 3;

v1::Recipe LatentRecipe() {
  auto recipe = ParseRecipe(
      "task { action { placement: PLACEMENT_ABSOLUTE } }"
      "network { latent { width: 3 } }",
      "test");
  EXPECT_THAT(recipe, IsOk());
  return WithDefaults(*recipe);
}

struct LatentRig : RolloutRig {
  LatentRig() : RolloutRig(LatentRecipe()) { UseLatentPolicy(); }
};

TEST(LatentRollout, TheSnapshotTellsTheLatentsNoiseFromTheActions) {
  LatentRig rig;

  const ActingGraph& policy = rig.snapshot->policy();

  EXPECT_THAT(policy.ports.noise, ElementsAre("noise", "action_noise"));
  EXPECT_EQ(policy.ports.latent_noise, "latent_noise");
  EXPECT_EQ(policy.latent_noise_width, kLatent);
  EXPECT_EQ(policy.std, std::vector<double>(kJoints, rig.std));
  EXPECT_EQ(RolloutRig().snapshot->policy().latent_noise_width, 0);
}

TEST(LatentRollout, FillsTheColumnsOfItsLayout) {
  LatentRig rig;

  const v1::Segment segment = rig.Run(rig.TrainOrder(3, 40));

  EXPECT_THAT(CheckColumns(segment, rig.assets->layout(), 40, 3), IsOk());
  EXPECT_THAT(CheckColumnsFinite(segment), IsOk());
  EXPECT_THAT(FindColumn(segment, "latent_noise")->shape(),
              ElementsAre(40, 3, kLatent));
  RolloutRig plain;
  EXPECT_EQ(FindColumn(plain.Run(plain.TrainOrder(1, 1)), "latent_noise"),
            nullptr);
}

TEST(LatentRollout, ShowsTheLatentOfAnEvaluationsSteps) {
  LatentRig rig;
  std::vector<std::vector<float>> latents;
  rig.worker->SetFrameObserver(
      [&](int, int, const mjData&, absl::Span<const float> latent) {
        latents.emplace_back(latent.begin(), latent.end());
      });

  rig.Run(rig.EvaluationOrder({{1, 0, 3}}));

  ASSERT_THAT(latents, SizeIs(3));
  for (const std::vector<float>& latent : latents) {
    EXPECT_THAT(latent, SizeIs(kLatent));
  }
  EXPECT_NE(latents[0], latents[1]);
}

TEST(LatentRollout, DrawsTheNoiseAnewForEveryStepAndEnvironment) {
  LatentRig rig;

  const v1::Segment segment = rig.Run(rig.StandingOrder(2, 6));

  // Both environments are in episode 5 for all 6 steps.
  ASSERT_EQ(segment.episodes_size(), 0);
  const auto noise = Column<float>(segment, "latent_noise");
  EXPECT_EQ(std::set<float>(noise.begin(), noise.end()).size(), noise.size());
  for (int t = 0; t < 6; ++t) {
    for (uint64_t e = 0; e < 2; ++e) {
      // Of the step's draw, the latent's numbers come first.
      std::vector<float> draw(kLatent + kJoints);
      FillNormal({.seed = 11,
                  .environment = e,
                  .episode = 5,
                  .step = static_cast<uint64_t>(t),
                  .purpose = RandomPurpose::kAction},
                 absl::MakeSpan(draw));
      for (int z = 0; z < kLatent; ++z) {
        EXPECT_EQ(noise[(t * 2 + e) * kLatent + z], draw[z]) << t << " " << e;
      }
    }
  }
}

TEST(LatentRollout, GivesTheSameBytesAgainAndInAnotherWorker) {
  LatentRig rig;

  rig.ExpectSameBytes(rig.TrainOrder(3, 40), /*other=*/rig.TrainOrder(2, 7));
}

TEST(LatentRollout, CutInTwoHalvesIsTheSameRollout) {
  LatentRig rig;

  EXPECT_GT(rig.RunWholeAndInHalves(3, 60).episodes_size(), 3);
}

TEST(LatentRollout, AnotherSeedDrawsOtherNoise) {
  LatentRig rig;
  v1::Order order = rig.StandingOrder(1, 3);
  const auto noise = Column<float>(rig.Run(order), "latent_noise");
  order.set_seed(order.seed() + 1);

  const auto other = Column<float>(rig.Run(order), "latent_noise");

  ASSERT_EQ(noise.size(), other.size());
  for (size_t i = 0; i < noise.size(); ++i) EXPECT_NE(noise[i], other[i]);
}

TEST(LatentRollout, LogProbabilityIsThatOfTheGaussianAroundTheMean) {
  LatentRig rig;

  const v1::Segment segment = rig.Run(rig.TrainOrder(2, 3));

  ASSERT_EQ(Column<float>(segment, "log_probability").size(), 6u);
  rig.ExpectGaussianLogProbabilities(segment);
}

// Whoever has observation and noise of a row knows its mean: the learner.
TEST(LatentRollout, ObservationAndNoiseOfARowGiveItsMean) {
  LatentRig rig;

  const v1::Segment segment = rig.Run(rig.TrainOrder(2, 5));

  const TensorMap weights =
      ParseSafetensors(rig.message.weights(), "rig").value();
  const auto executor =
      policy::Executor::Create(
          policy::PackWeights(rig.message.graph(), "policy", weights).value(),
          /*max_batch=*/1)
          .value();
  const auto observation = Column<float>(segment, "observation");
  const auto noise = Column<float>(segment, "latent_noise");
  const auto mean = Column<float>(segment, "action_mean");
  const size_t rows = mean.size() / kJoints;
  const size_t width = observation.size() / rows;
  for (size_t row = 0; row < rows; ++row) {
    std::copy_n(observation.begin() + static_cast<int64_t>(row * width), width,
                executor->input(executor->input_index("observation")).begin());
    std::copy_n(noise.begin() + static_cast<int64_t>(row * kLatent), kLatent,
                executor->input(executor->input_index("noise")).begin());
    executor->Run(1);
    const auto found = executor->tap(executor->tap_index("mean"));
    for (size_t j = 0; j < kJoints; ++j) {
      EXPECT_EQ(found[j], mean[row * kJoints + j]) << row;
    }
  }
}

// Of two posteriors with one mean, whatever they are unsure about, and without
// exploration.
TEST(LatentRollout, EvaluatesWithTheMeanOfLatentAndAction) {
  LatentRig rig;
  std::vector<std::string> results;
  std::vector<std::vector<float>> means;
  for (const float log_variance : {-100.0F, 100.0F}) {
    rig.SetParameter("encoder/log_variance/bias", log_variance);
    rig.SetParameter("policy/std", log_variance > 0 ? 1.0F : 0.1F);
    rig.Run(rig.TrainOrder(2, 3));  // noise that must not be left over
    const v1::Segment segment =
        rig.Run(rig.EvaluationOrder({{1, 0, 19}, {0, 3, 20}}));
    results.push_back(SerializeDeterministically(segment.results(0)) +
                      SerializeDeterministically(segment.results(1)));
    means.push_back(
        Column<float>(rig.Run(rig.StandingOrder(1, 1)), "action_mean"));
  }

  EXPECT_EQ(results[0], results[1]);
  EXPECT_NE(means[0], means[1]);
}

TEST(LatentRollout, TrainingNeedsAPolicyWithThatLatent) {
  RolloutRig rig(LatentRecipe());  // one network without

  EXPECT_THAT(rig.worker->Run(rig.TrainOrder(1, 5), *rig.snapshot),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("a tap \"latent_noise\" of width 3, since "
                                 "recipe field network.latent is set without "
                                 "distillation, found 0")));
  EXPECT_THAT(rig.worker->Run(rig.EvaluationOrder({{1, 0, 5}}), *rig.snapshot),
              IsOk());
}

TEST(LatentRollout, LongerOrdersAllocateNoMoreThanShortOnes) {
  LatentRig rig;

  EXPECT_EQ(testing::OrderAllocations(rig, 4),
            testing::OrderAllocations(rig, 6));
}

}  // namespace
}  // namespace sinew::actor
