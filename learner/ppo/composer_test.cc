// A composer learns to weigh frozen primitives.

#include <cmath>
#include <cstdint>
#include <memory>
#include <numeric>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "common/policy/builder.h"
#include "common/policy/safetensors.h"
#include "common/segment/segment_layout.h"
#include "common/testing/matchers.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "learner/ppo/batch.h"
#include "learner/ppo/ppo_learner.h"
#include "learner/ppo/ppo_networks.h"
#include "learner/ppo/synthetic_segments.h"
#include "learner/ppo/testing/ppo_rig.h"
#include "learner/torch/graph_module.h"
#include "learner/update/initial_weights.h"

namespace sinew::learner {
namespace {

using ::sinew::testing::IsOk;
using ::sinew::testing::StatusIs;
using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

constexpr auto kInvalid = absl::StatusCode::kInvalidArgument;

v1::Recipe ComposerRecipe(const std::string& overrides = "") {
  return MakeRecipe("network { composer { primitives: 2 hidden: 16 } }" +
                    overrides);
}

// The weights of a run of one network, as its bundle has them: no critic.
TensorMap TrainedWeights(int iterations, uint64_t seed = 7) {
  const auto learner = MakeLearner(MakeRecipe(absl::StrCat("seed: ", seed)));
  for (int64_t i = 0; i < iterations; ++i) UpdateOnce(*learner, i);
  TensorMap weights = learner->weights();
  std::erase_if(weights, [](const auto& one) {
    return absl::StartsWith(one.first, "critic/");
  });
  return weights;
}

// One that has learned and one that has not.
const std::vector<Primitive>& Primitives() {
  static const auto* primitives = new std::vector<Primitive>(
      {{"runs/good", TrainedWeights(60)}, {"runs/poor", TrainedWeights(0, 8)}});
  return *primitives;
}

std::unique_ptr<PpoLearner> MakeComposer(const v1::Recipe& recipe, int ranks) {
  auto learner = MakeLearner(recipe, ranks);
  EXPECT_THAT(learner->InitFromPrimitives(Primitives()), IsOk());
  return learner;
}

std::unique_ptr<PpoLearner> MakeComposer() {
  return MakeComposer(ComposerRecipe(), /*ranks=*/2);
}

// Means of all rows, as their bytes.
std::string Means(const std::vector<v1::Segment>& segments) {
  std::string means;
  for (const v1::Segment& segment : segments) {
    means += FindColumn(segment, column::kActionMean)->data();
  }
  return means;
}

TEST(Composer, LearnsToWeighItsPrimitives) {
  const auto learner = MakeComposer();
  const double before = MeanActionError(Collect(*learner, 1000));

  for (int64_t i = 0; i < 30; ++i) UpdateOnce(*learner, i);

  EXPECT_LT(MeanActionError(Collect(*learner, 1000)), before / 2);
}

TEST(Composer, TrainsNothingElse) {
  const auto learner = MakeComposer();
  const TensorMap before = learner->weights();

  for (int64_t i = 0; i < 3; ++i) UpdateOnce(*learner, i);

  const TensorMap after = learner->SaveTensors();
  int primitives = 0, trained = 0;
  for (const auto& [name, tensor] : before) {
    if (absl::StartsWith(name, "primitive_")) {
      ++primitives;
      EXPECT_EQ(after.at(name).data, tensor.data) << name;
      EXPECT_FALSE(after.contains("adam/first_moment/" + name));
    } else if (absl::StartsWith(name, "composer/")) {
      ++trained;
      EXPECT_NE(after.at(name).data, tensor.data) << name;
      EXPECT_TRUE(after.contains("adam/first_moment/" + name));
    }
  }
  EXPECT_EQ(primitives, 2 * (2 + 3 * 2));
  EXPECT_EQ(trained, 2 * 2);
}

TEST(Composer, HoldsItsPrimitivesBitForBit) {
  const TensorMap weights = MakeComposer()->weights();

  for (int k = 0; k < 2; ++k) {
    for (const auto& [name, tensor] : Primitives()[k].weights) {
      if (name == "policy/std") continue;
      EXPECT_EQ(weights.at(policy::PrimitiveParameter(k, name)).data,
                tensor.data)
          << k << " " << name;
    }
  }
  EXPECT_FLOAT_EQ(weights.at("policy/std").float32()[0], 0.3f);
  for (const char* name : {"normaliser/mean", "normaliser/inverse_std"}) {
    EXPECT_EQ(weights.at(name).data, Primitives()[0].weights.at(name).data);
  }
}

TEST(Composer, OfEqualPrimitivesWithEqualWeightsActsAsThePrimitive) {
  const Primitive& good = Primitives()[0];
  const auto learner = MakeLearner(ComposerRecipe());
  ASSERT_THAT(learner->InitFromPrimitives({good, good}), IsOk());
  TensorMap weights = learner->weights();
  HostTensor& last = weights.at("composer/weights/weight");
  last = HostTensor::Zeros(last.shape);
  const auto alone = MakeLearner(MakeRecipe());
  ASSERT_THAT(alone->InitFrom(good.weights), IsOk());

  const auto composed =
      MakeSyntheticSegments({}, learner->graph(), weights, /*iteration=*/9);

  EXPECT_EQ(Means(composed), Means(Collect(*alone, /*iteration=*/9)));
}

TEST(Composer, ResumesWithoutItsPrimitivesBundles) {
  const auto learner = MakeComposer();
  for (int64_t i = 0; i < 3; ++i) UpdateOnce(*learner, i);
  const TensorMap tensors = learner->SaveTensors();
  v1::TrainingState state;
  learner->SaveCounters(state);
  for (int64_t i = 3; i < 5; ++i) UpdateOnce(*learner, i);

  const auto resumed = MakeLearner(ComposerRecipe(), /*ranks=*/1);
  ASSERT_THAT(resumed->Load(tensors, state, /*chunks=*/{}), IsOk());
  EXPECT_EQ(SerializeSafetensors(resumed->SaveTensors()),
            SerializeSafetensors(tensors));
  for (int64_t i = 3; i < 5; ++i) UpdateOnce(*resumed, i);

  EXPECT_EQ(Bits(*resumed), Bits(*learner));
}

TEST(Composer, StartsFromAnotherComposersWeights) {
  const auto learner = MakeComposer();
  for (int64_t i = 0; i < 3; ++i) UpdateOnce(*learner, i);
  const auto other = MakeLearner(ComposerRecipe());

  ASSERT_THAT(other->InitFrom(learner->weights()), IsOk());

  EXPECT_EQ(Means(Collect(*other, 5)), Means(Collect(*learner, 5)));
  UpdateOnce(*other, 0);
}

TEST(Composer, RefusesToLearnWithoutPrimitives) {
  const auto learner = MakeLearner(ComposerRecipe());
  const std::vector<v1::Segment> segments = Collect(*learner, 0);

  EXPECT_THAT(learner->Update(Pointers(segments), 0).status(),
              StatusIs(absl::StatusCode::kFailedPrecondition,
                       AllOf(HasSubstr("network.composer"),
                             HasSubstr("expected the weights of 2 primitives"),
                             HasSubstr("found none"))));
}

TEST(Composer, RefusesPrimitivesThatDoNotFit) {
  const auto learner = MakeLearner(ComposerRecipe());
  const std::string before = Bits(*learner);
  const Primitive& good = Primitives()[0];
  const auto refused = [&](Primitive second) {
    second.name = "runs/second";
    return learner->InitFromPrimitives({good, std::move(second)});
  };

  EXPECT_THAT(
      learner->InitFromPrimitives({good}),
      StatusIs(kInvalid, AllOf(HasSubstr("network.composer.primitives"),
                               HasSubstr("expected 2"), HasSubstr("found 1"))));
  EXPECT_THAT(learner->InitFromPrimitives({good, good, good}),
              StatusIs(kInvalid, HasSubstr("found 3")));
  Primitive odd = good;
  odd.weights["policy/linear_0/weight"] = HostTensor::Zeros({64, 6});
  EXPECT_THAT(refused(odd),
              StatusIs(kInvalid,
                       "runs/second: tensor policy/linear_0/weight: expected "
                       "shape [32, 6], found shape [64, 6]"));
  odd = good;
  odd.weights.erase("policy/linear_1/bias");
  EXPECT_THAT(refused(odd),
              StatusIs(kInvalid,
                       "runs/second: tensor policy/linear_1/bias: expected "
                       "shape [32], found none"));
  odd = good;
  odd.weights["policy/linear_2/bias"] = HostTensor::Zeros({32});
  EXPECT_THAT(refused(odd),
              StatusIs(kInvalid, AllOf(HasSubstr("runs/second"),
                                       HasSubstr("policy/linear_2/bias"),
                                       HasSubstr("expected none"))));
  odd = good;
  odd.weights.at("policy/mean/bias").mutable_float32()[0] = NAN;
  EXPECT_THAT(refused(odd),
              StatusIs(kInvalid, AllOf(HasSubstr("runs/second"),
                                       HasSubstr("policy/mean/bias"))));
  EXPECT_THAT(refused({"", MakeComposer()->weights()}),
              StatusIs(kInvalid, AllOf(HasSubstr("runs/second"),
                                       HasSubstr("found a composer"))));
  EXPECT_EQ(Bits(*learner), before);
}

TEST(Composer, IsNotTakenForAPolicyOfOneNetworkNorTheOtherWayRound) {
  const auto alone = MakeLearner(MakeRecipe());
  const auto composer = MakeComposer();

  EXPECT_THAT(alone->InitFrom(composer->weights()),
              StatusIs(kInvalid, AllOf(HasSubstr("policy/linear_0"),
                                       HasSubstr("found none"))));
  EXPECT_THAT(composer->InitFrom(alone->weights()),
              StatusIs(kInvalid, AllOf(HasSubstr("composer/linear_0"),
                                       HasSubstr("found none"))));
  EXPECT_THAT(
      alone->InitFromPrimitives(Primitives()),
      StatusIs(kInvalid, HasSubstr("recipe field network.composer: expected")));
}

TEST(Composer, ComputesItsPrimitivesOncePerRow) {
  const auto learner = MakeComposer(
      ComposerRecipe("ppo { epochs: 1 kl_stop: 1e9 }"), /*ranks=*/2);
  const SyntheticProblem problem = {.truncated_share = 0};

  const UpdateStatistics statistics = UpdateOnce(*learner, 0, problem);

  // Multiply-adds a row: a primitive 6*32 + 32*32 + 32*3 = 1312, the composer
  // 6*16 + 16*2 = 128 and backwards 96 + 64 = 160; critic 1248 and 2304.
  const double once = 2.0 * (2 * 1312 + 1248) * (2048 + 64);  // 64: boundary
  const double trained = 2.0 * (128 + 160 + 1248 + 2304) * 2048;
  const double kl = 2.0 * 128 * 512;
  EXPECT_EQ(statistics.flops, once + trained + kl);
}

TEST(Composer, FreezesObservationAndPrimitivesAsOneFrontier) {
  const auto learner = MakeLearner(ComposerRecipe());
  const auto module =
      GraphModule::Create(learner->graph(), "policy", Precision::kFloat32);
  ASSERT_THAT(module, IsOk());

  EXPECT_THAT((*module)->FrozenFrontier({"mean"}),
              ElementsAre("clipped", "primitive_0/mean", "primitive_1/mean"));
  EXPECT_THAT((*module)->FrozenFrontier({"weights"}), ElementsAre("clipped"));
}

// What LoadObservations has computed stays as it was then: primitives that are
// exchanged afterwards change nothing until the next batch.
TEST(Composer, NetworksReadTheirPrimitivesWhenObservationsAreLoaded) {
  const auto learner = MakeComposer();
  const std::vector<v1::Segment> segments = Collect(*learner, 0);
  const TensorMap weights = learner->weights();
  const auto networks =
      PpoNetworks::Create(learner->graph(), weights, {.shards = 1});
  ASSERT_THAT(networks, IsOk());
  Batch batch(3, MakeSegmentLayout(6, 3), 0.1, 0.95);
  ASSERT_THAT(batch.Reset(Pointers(segments)), IsOk());
  ASSERT_THAT((*networks)->Reserve(batch.rows() + batch.bootstrap_rows()),
              IsOk());
  const auto load = [&] {
    for (int s = 0; s < batch.num_segments(); ++s) {
      batch.CopyColumns(s);
      for (const Batch::Block& block : batch.Blocks(s)) {
        ASSERT_THAT(
            (*networks)->LoadObservations(block.first_row, block.observations),
            IsOk());
      }
    }
  };
  load();
  ASSERT_THAT((*networks)->Values(0, batch.values()), IsOk());
  for (int s = 0; s < batch.num_segments(); ++s) batch.ComputeReturns(s);
  batch.Finish();
  ASSERT_THAT((*networks)->SetTargets(batch), IsOk());
  std::vector<int64_t> rows(batch.rows());
  std::iota(rows.begin(), rows.end(), 0);
  const auto kl = [&] { return (*networks)->PolicyFigures(rows, 1)->kl; };
  // What acted, up to the difference of the back ends.
  EXPECT_LT(kl(), 1e-6 * static_cast<double>(rows.size()));

  TensorMap other = weights;
  for (float& bias :
       other.at("primitive_1/policy/mean/bias").mutable_float32()) {
    bias += 1;
  }
  ASSERT_THAT((*networks)->LoadWeights(other), IsOk());
  EXPECT_LT(kl(), 1e-6 * static_cast<double>(rows.size()));

  load();
  // The mean has moved by about a half in each of 3 actions of std 0.3:
  // 3 (0.5 / 0.3)^2 / 2 = 4.2 a row.
  EXPECT_GT(kl(), 2.0 * static_cast<double>(rows.size()));
}

}  // namespace
}  // namespace sinew::learner
