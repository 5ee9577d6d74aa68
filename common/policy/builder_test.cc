#include "common/policy/builder.h"

#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "absl/strings/match.h"
#include "absl/types/span.h"
#include "common/policy/executor.h"
#include "common/policy/safetensors.h"
#include "common/policy/validate.h"
#include "common/random/philox.h"
#include "common/testing/matchers.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace sinew::policy {
namespace {

using ::sinew::testing::IsOk;
using ::sinew::testing::StatusIs;
using ::testing::HasSubstr;

TrackingPolicyOptions SmallOptions() {
  TrackingPolicyOptions options{.observation_width = 21, .action_width = 5};
  options.network.add_policy_hidden(32);
  options.network.add_policy_hidden(24);
  options.network.add_value_hidden(16);
  options.network.set_activation(v1::Network::ACTIVATION_SILU);
  options.network.set_last_layer_gain(0.01);
  options.network.set_observation_clip(8);
  options.network.set_initial_std(0.4);
  return options;
}

TrackingPolicyOptions ComposerOptions(int primitives) {
  TrackingPolicyOptions options = SmallOptions();
  options.network.mutable_composer()->set_primitives(primitives);
  options.network.mutable_composer()->add_hidden(12);
  return options;
}

// A composer's initial weights, with the policy of `weights` in each of its
// primitives.
TensorMap Composed(const TrackingPolicyOptions& options,
                   const TensorMap& weights) {
  TensorMap composed = *InitialWeights(options, 5);
  for (int k = 0; k < options.network.composer().primitives(); ++k) {
    for (const auto& [name, tensor] : weights) {
      const auto found = composed.find(PrimitiveParameter(k, name));
      if (found != composed.end()) found->second = tensor;
    }
  }
  return composed;
}

// A tap of the graph "policy" for nine rows of observations.
std::vector<float> TapOf(const TrackingPolicyOptions& options,
                         const TensorMap& weights, const std::string& tap) {
  const auto graph = *BuildTrackingPolicy(options);
  auto executor = *Executor::Create(*PackWeights(graph, "policy", weights), 9);
  FillNormal({.seed = 2},
             executor->input(executor->input_index("observation")));
  executor->Run(9);
  const auto values = executor->tap(executor->tap_index(tap));
  return {values.begin(), values.end()};
}

// Largest deviation of W W^T (or W^T W) from gain^2 times the identity.
double OrthogonalityError(const HostTensor& weight, double gain) {
  const int64_t out = weight.shape[0];
  const int64_t in = weight.shape[1];
  const absl::Span<const float> w = weight.float32();
  const int64_t count = std::min(out, in);
  double worst = 0;
  for (int64_t a = 0; a < count; ++a) {
    for (int64_t b = 0; b < count; ++b) {
      double dot = 0;
      for (int64_t k = 0; k < std::max(out, in); ++k) {
        dot += out <= in ? double{w[a * in + k]} * w[b * in + k]
                         : double{w[k * in + a]} * w[k * in + b];
      }
      worst = std::max(worst, std::abs(dot - (a == b ? gain * gain : 0)));
    }
  }
  return worst;
}

TEST(Builder, MakesGraphsThatAreValidWithTheirInitialWeights) {
  const auto graph = BuildTrackingPolicy(SmallOptions());
  const auto weights = InitialWeights(SmallOptions(), 1);

  ASSERT_THAT(graph.status(), IsOk());
  ASSERT_THAT(weights.status(), IsOk());
  EXPECT_THAT(ValidateGraph(*graph, *weights), IsOk());
  EXPECT_EQ(weights->size(), graph->parameters_size());
}

TEST(Builder, ActsWithTheMeanWhenTheNoiseIsZero) {
  const auto graph = *BuildTrackingPolicy(SmallOptions());
  const auto weights = *InitialWeights(SmallOptions(), 1);
  auto executor = *Executor::Create(*PackWeights(graph, "policy", weights), 3);
  FillNormal({.seed = 2},
             executor->input(executor->input_index("observation")));

  executor->Run(3);

  const auto action = executor->tap(executor->tap_index("action"));
  const auto mean = executor->tap(executor->tap_index("mean"));
  EXPECT_THAT(action, ::testing::ElementsAreArray(mean));
  EXPECT_NE(mean[0], 0.0f);
}

TEST(Builder, ScalesTheNoiseByTheStandardDeviation) {
  const auto graph = *BuildTrackingPolicy(SmallOptions());
  const auto weights = *InitialWeights(SmallOptions(), 1);
  auto executor = *Executor::Create(*PackWeights(graph, "policy", weights), 1);
  const auto noise = executor->input(executor->input_index("noise"));
  for (float& n : noise) n = -2.5f;

  executor->Run(1);

  // -2.5 standard deviations of 0.4.
  const auto action = executor->tap(executor->tap_index("action"));
  const auto mean = executor->tap(executor->tap_index("mean"));
  for (int i = 0; i < 5; ++i) EXPECT_NEAR(action[i] - mean[i], -1.0f, 1e-6f);
}

TEST(Builder, InitialWeightsAreOrthogonalWithTheirGains) {
  const auto weights = *InitialWeights(SmallOptions(), 7);

  EXPECT_LT(
      OrthogonalityError(weights.at("policy/linear_0/weight"), std::sqrt(2.0)),
      1e-6);
  EXPECT_LT(
      OrthogonalityError(weights.at("policy/linear_1/weight"), std::sqrt(2.0)),
      1e-6);
  EXPECT_LT(OrthogonalityError(weights.at("policy/mean/weight"), 0.01), 1e-6);
  EXPECT_LT(OrthogonalityError(weights.at("critic/value/weight"), 1.0), 1e-6);
}

TEST(Builder, InitialWeightsAreAFunctionOfTheSeed) {
  const auto one = *InitialWeights(SmallOptions(), 7);
  const auto again = *InitialWeights(SmallOptions(), 7);
  const auto other = *InitialWeights(SmallOptions(), 8);

  EXPECT_EQ(SerializeSafetensors(one), SerializeSafetensors(again));
  EXPECT_NE(SerializeSafetensors(one), SerializeSafetensors(other));
}

TEST(Builder, FreezesNormaliserAndExploration) {
  const auto graph = *BuildTrackingPolicy(SmallOptions());

  for (const v1::Parameter& parameter : graph.parameters()) {
    const bool frozen = parameter.name() == "normaliser/mean" ||
                        parameter.name() == "normaliser/inverse_std" ||
                        parameter.name() == "policy/std";
    EXPECT_EQ(parameter.frozen(), frozen) << parameter.name();
  }
}

TEST(Builder, ComposerIsValidWithItsInitialWeights) {
  for (const int primitives : {2, 3, 16}) {
    const auto graph = BuildTrackingPolicy(ComposerOptions(primitives));
    const auto weights = InitialWeights(ComposerOptions(primitives), 1);

    ASSERT_THAT(graph.status(), IsOk());
    ASSERT_THAT(weights.status(), IsOk());
    EXPECT_THAT(ValidateGraph(*graph, *weights), IsOk());
    EXPECT_EQ(weights->size(), graph->parameters_size());
  }
}

TEST(Builder, ComposerOfEqualPrimitivesWithEqualWeightsActsAsThePrimitive) {
  TensorMap alone = *InitialWeights(SmallOptions(), 7);
  FillNormal({.seed = 3}, alone.at("normaliser/mean").mutable_float32());
  const std::vector<float> expected = TapOf(SmallOptions(), alone, "mean");
  for (const int primitives : {2, 3, 4}) {
    const TrackingPolicyOptions options = ComposerOptions(primitives);
    TensorMap composed = Composed(options, alone);
    HostTensor& last = composed.at("composer/weights/weight");
    last = HostTensor::Zeros(last.shape);

    const std::vector<float> mean = TapOf(options, composed, "mean");
    const std::vector<float> weights =
        TapOf(options, composed, "composer_weights");

    ASSERT_EQ(weights.size(), 9 * primitives);
    for (const float weight : weights) {
      EXPECT_EQ(weight, static_cast<float>(1.0 / primitives));
    }
    ASSERT_EQ(mean.size(), expected.size());
    for (size_t i = 0; i < mean.size(); ++i) {
      // Halves and quarters are exact.
      const float tolerance =
          primitives == 3 ? 1e-6f * std::abs(expected[i]) : 0;
      EXPECT_NEAR(mean[i], expected[i], tolerance);
    }
  }
}

TEST(Builder, ComposerBeginsCloseToTheMeanOfItsPrimitives) {
  const TensorMap alone = *InitialWeights(SmallOptions(), 7);
  const TrackingPolicyOptions options = ComposerOptions(3);

  for (const float weight :
       TapOf(options, Composed(options, alone), "composer_weights")) {
    EXPECT_NEAR(weight, 1.0 / 3, 0.05);
  }
}

TEST(Builder, ComposerTrainsItsOwnLayersAndTheCriticOnly) {
  const auto graph = *BuildTrackingPolicy(ComposerOptions(2));

  int frozen = 0;
  for (const v1::Parameter& parameter : graph.parameters()) {
    const bool layer = absl::EndsWith(parameter.name(), "/weight") ||
                       absl::EndsWith(parameter.name(), "/bias");
    const bool trained =
        layer && (absl::StartsWith(parameter.name(), "composer/") ||
                  absl::StartsWith(parameter.name(), "critic/"));
    EXPECT_EQ(parameter.frozen(), !trained) << parameter.name();
    frozen += parameter.frozen();
  }
  // Normaliser 2 and standard deviation; of each primitive 2 and 3 layers.
  EXPECT_EQ(frozen, 3 + 2 * (2 + 3 * 2));
}

TEST(Builder, APolicyWithoutComposerHasNoTapOfItsWeights) {
  const auto graph = *BuildTrackingPolicy(SmallOptions());

  EXPECT_EQ(graph.graphs(0).taps_size(), 2);
}

TEST(Builder, NamesTheOptionThatIsWrong) {
  TrackingPolicyOptions options = SmallOptions();
  options.network.set_initial_std(-1);
  EXPECT_THAT(BuildTrackingPolicy(options),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       "network.initial_std: expected > 0, found -1"));

  options = SmallOptions();
  options.network.set_activation(v1::Network::ACTIVATION_UNSPECIFIED);
  EXPECT_THAT(BuildTrackingPolicy(options),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("network.activation: expected SILU")));

  EXPECT_THAT(
      BuildTrackingPolicy(ComposerOptions(1)),
      StatusIs(absl::StatusCode::kInvalidArgument,
               "network.composer.primitives: expected 2 to 16, found 1"));
  options = ComposerOptions(2);
  options.network.mutable_composer()->add_hidden(0);
  EXPECT_THAT(BuildTrackingPolicy(options),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       "network.composer.hidden: expected >= 1, found 0"));
}

}  // namespace
}  // namespace sinew::policy
