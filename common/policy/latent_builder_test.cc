#include "common/policy/latent_builder.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <set>
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

using ::sinew::testing::EqualsProto;
using ::sinew::testing::IsOk;
using ::sinew::testing::StatusIs;
using ::testing::Each;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

constexpr int kRows = 3, kSelf = 7, kObservation = 12, kAction = 5, kLatent = 4;

LatentPolicyOptions SmallOptions() {
  LatentPolicyOptions options{.self_observation_width = kSelf,
                              .observation_width = kObservation,
                              .action_width = kAction};
  options.network.set_activation(v1::Network::ACTIVATION_SILU);
  options.network.set_last_layer_gain(0.3);
  options.network.set_observation_clip(8);
  v1::Latent& latent = *options.network.mutable_latent();
  latent.set_width(kLatent);
  latent.add_encoder_hidden(16);
  latent.add_encoder_hidden(9);
  latent.add_prior_hidden(11);
  latent.add_decoder_hidden(13);
  latent.set_log_variance_low(-5);
  latent.set_log_variance_high(2);
  return options;
}

// The same where it is to be learnt by PPO.
LatentPolicyOptions ExploringOptions() {
  LatentPolicyOptions options = SmallOptions();
  options.explores = true;
  options.network.add_value_hidden(6);
  options.network.set_initial_std(0.5);
  return options;
}

// Initial weights with normalisers and biases that do something.
TensorMap LivelyWeights(const LatentPolicyOptions& options = SmallOptions()) {
  TensorMap weights = *InitialLatentWeights(options, 3);
  uint64_t index = 0;
  for (auto& [name, tensor] : weights) {
    if (!absl::EndsWith(name, "/mean") && !absl::EndsWith(name, "/bias")) {
      continue;
    }
    FillNormal({.seed = 5, .environment = index++}, tensor.mutable_float32());
  }
  return weights;
}

using Values = std::map<std::string, std::vector<float>>;

// All taps of a graph for kRows rows of inputs.
Values RunGraph(const std::string& name, const TensorMap& weights,
                const Values& inputs,
                const LatentPolicyOptions& options = SmallOptions()) {
  const v1::PolicyGraph graph = *BuildLatentPolicy(options);
  auto executor = *Executor::Create(*PackWeights(graph, name, weights), kRows);
  for (const auto& [input, values] : inputs) {
    const auto to = executor->input(executor->input_index(input));
    EXPECT_EQ(to.size(), values.size()) << input;
    std::copy(values.begin(), values.end(), to.begin());
  }
  executor->Run(kRows);
  Values taps;
  for (const v1::Tap& tap : (*FindGraph(graph, name))->taps()) {
    const auto values = executor->tap(executor->tap_index(tap.name()));
    taps[tap.name()].assign(values.begin(), values.end());
  }
  return taps;
}

std::vector<float> Normal(uint64_t seed, int width) {
  std::vector<float> values(kRows * width);
  FillNormal({.seed = seed}, absl::MakeSpan(values));
  return values;
}

// The first kSelf columns of observations.
std::vector<float> OwnColumns(const std::vector<float>& observations) {
  std::vector<float> own;
  for (int row = 0; row < kRows; ++row) {
    const auto* begin = observations.data() + row * kObservation;
    own.insert(own.end(), begin, begin + kSelf);
  }
  return own;
}

std::set<std::string> ParametersOf(const v1::Graph& graph) {
  std::set<std::string> names;
  for (const v1::Node& node : graph.nodes()) {
    names.insert(node.parameters().begin(), node.parameters().end());
  }
  return names;
}

TEST(LatentBuilder, MakesGraphsThatAreValidWithTheirInitialWeights) {
  const auto graph = BuildLatentPolicy(SmallOptions());
  const auto weights = InitialLatentWeights(SmallOptions(), 1);

  ASSERT_THAT(graph.status(), IsOk());
  ASSERT_THAT(weights.status(), IsOk());
  EXPECT_THAT(ValidateGraph(*graph, *weights), IsOk());
  EXPECT_EQ(weights->size(), graph->parameters_size());
  std::set<std::string> names;
  for (const v1::Graph& one : graph->graphs()) names.insert(one.name());
  EXPECT_THAT(names,
              ElementsAre("decoder", "encoder", "policy", "prior", "sample"));
}

TEST(LatentBuilder, LayersMayBeAbsent) {
  LatentPolicyOptions options = SmallOptions();
  options.network.mutable_latent()->clear_encoder_hidden();
  options.network.mutable_latent()->clear_prior_hidden();
  options.network.mutable_latent()->clear_decoder_hidden();

  EXPECT_THAT(BuildLatentPolicy(options), IsOk());
}

TEST(LatentBuilder, SamplesAsPriorAndDecoderDo) {
  const TensorMap weights = LivelyWeights();
  const std::vector<float> own = Normal(11, kSelf), noise = Normal(12, kLatent);
  const Values prior = RunGraph("prior", weights, {{"self_observation", own}});
  std::vector<float> latent(noise.size());
  for (size_t i = 0; i < latent.size(); ++i) {
    const float step = prior.at("std")[i] * noise[i];
    latent[i] = prior.at("mean")[i] + step;
  }

  const Values sample = RunGraph("sample", weights,
                                 {{"self_observation", own}, {"noise", noise}});

  ASSERT_EQ(sample.at("latent").size(), latent.size());
  for (size_t i = 0; i < latent.size(); ++i) {
    EXPECT_NEAR(sample.at("latent")[i], latent[i], 1e-6f);
  }
  EXPECT_EQ(sample.at("action"), RunGraph("decoder", weights,
                                          {{"self_observation", own},
                                           {"latent", sample.at("latent")}})
                                     .at("action"));
}

TEST(LatentBuilder, ActsWithoutNoiseAsTheDecoderOfThePosteriorsMean) {
  const TensorMap weights = LivelyWeights();
  const std::vector<float> observation = Normal(21, kObservation);
  const Values posterior =
      RunGraph("encoder", weights, {{"observation", observation}});

  const Values policy =
      RunGraph("policy", weights, {{"observation", observation}});

  EXPECT_EQ(policy.at("latent"), posterior.at("mean"));
  EXPECT_EQ(policy.at("mean"), policy.at("action"));
  EXPECT_EQ(policy.at("action"),
            RunGraph("decoder", weights,
                     {{"self_observation", OwnColumns(observation)},
                      {"latent", posterior.at("mean")}})
                .at("action"));
}

TEST(LatentBuilder, NoiseMovesTheLatentByThePosteriorsDeviation) {
  const TensorMap weights = LivelyWeights();
  const std::vector<float> observation = Normal(31, kObservation);
  const Values posterior =
      RunGraph("encoder", weights, {{"observation", observation}});

  const Values policy =
      RunGraph("policy", weights,
               {{"observation", observation},
                {"noise", std::vector<float>(kRows * kLatent, -2)}});

  for (size_t i = 0; i < kRows * kLatent; ++i) {
    EXPECT_NEAR(policy.at("latent")[i],
                posterior.at("mean")[i] - 2 * posterior.at("std")[i], 1e-5f);
  }
}

TEST(LatentBuilder, TheDeviationIsTheExponentialOfHalfTheLogVariance) {
  TensorMap weights = LivelyWeights();
  // Beyond both ends of the range, and within it.
  HostTensor& bias = weights.at("prior/log_variance/bias");
  bias = HostTensor::Float32({kLatent}, {-100, 100, 0.5f, -1});

  const Values prior =
      RunGraph("prior", weights, {{"self_observation", Normal(41, kSelf)}});

  for (size_t i = 0; i < kRows * kLatent; ++i) {
    EXPECT_NEAR(prior.at("std")[i], std::exp(prior.at("log_variance")[i] / 2),
                1e-5f);
  }
  for (int row = 0; row < kRows; ++row) {
    EXPECT_EQ(prior.at("log_variance")[row * kLatent], -5);
    EXPECT_EQ(prior.at("log_variance")[row * kLatent + 1], 2);
  }
}

double Silu(double x) { return x / (1 + std::exp(-x)); }

// One column of own state, one of goal, one of latent and action; layers of
// one. All is worked out by hand.
TEST(LatentBuilder, ComputesWhatItsHeaderSays) {
  LatentPolicyOptions options{
      .self_observation_width = 1, .observation_width = 2, .action_width = 1};
  options.network = SmallOptions().network;
  options.network.set_observation_clip(1.5);
  v1::Latent& latent = *options.network.mutable_latent();
  latent.set_width(1);
  latent.mutable_encoder_hidden()->Resize(1, 0);
  latent.set_encoder_hidden(0, 1);
  latent.set_prior_hidden(0, 1);
  latent.set_decoder_hidden(0, 1);
  TensorMap weights = *InitialLatentWeights(options, 1);
  const auto set = [&](const std::string& name,
                       std::initializer_list<float> values) {
    const auto to = weights.at(name).mutable_float32();
    ASSERT_EQ(to.size(), values.size()) << name;
    std::copy(values.begin(), values.end(), to.begin());
  };
  set("normaliser/own/mean", {1});
  set("normaliser/own/inverse_std", {0.5f});
  set("normaliser/goal/mean", {-1});
  set("normaliser/goal/inverse_std", {2});
  set("encoder/linear_0/weight", {0.4f, -0.8f});
  set("encoder/linear_0/bias", {0.1f});
  set("encoder/mean/weight", {1.5f});
  set("encoder/mean/bias", {-0.2f});
  set("encoder/log_variance/weight", {-0.7f});
  set("encoder/log_variance/bias", {0.3f});
  set("decoder/linear_0/weight", {0.9f, 1.1f});
  set("decoder/linear_0/bias", {-0.3f});
  set("decoder/action/weight", {2});
  set("decoder/action/bias", {0.05f});
  const auto graph = *BuildLatentPolicy(options);
  auto executor = *Executor::Create(*PackWeights(graph, "policy", weights), 1);
  const auto observation =
      executor->input(executor->input_index("observation"));
  observation[0] = 1.6f;
  observation[1] = 4;
  executor->input(executor->input_index("noise"))[0] = 0.5f;

  executor->Run(1);

  const double own = (1.6 - 1) * 0.5, goal = 1.5;  // (4 + 1) * 2, clipped
  const double encoded = Silu(0.4 * own - 0.8 * goal + 0.1);
  const double z =
      1.5 * encoded - 0.2 + 0.5 * std::exp((-0.7 * encoded + 0.3) / 2);
  const double action = 2 * Silu(0.9 * own + 1.1 * z - 0.3) + 0.05;
  EXPECT_NEAR(executor->tap(executor->tap_index("latent"))[0], z, 1e-5);
  EXPECT_NEAR(executor->tap(executor->tap_index("action"))[0], action, 1e-5);
}

TEST(LatentBuilder, SharesParametersBetweenGraphsByName) {
  const auto graph = *BuildLatentPolicy(SmallOptions());
  const auto of = [&](const char* name) {
    return ParametersOf(**FindGraph(graph, name));
  };
  const auto both = [](std::set<std::string> a,
                       const std::set<std::string>& b) {
    a.insert(b.begin(), b.end());
    return a;
  };

  EXPECT_EQ(of("policy"), both(of("encoder"), of("decoder")));
  EXPECT_EQ(of("sample"), both(of("prior"), of("decoder")));
  EXPECT_THAT(of("decoder"),
              ElementsAre("decoder/action/bias", "decoder/action/weight",
                          "decoder/linear_0/bias", "decoder/linear_0/weight",
                          "normaliser/own/inverse_std", "normaliser/own/mean"));
  EXPECT_FALSE(of("prior").contains("normaliser/goal/mean"));
}

TEST(LatentBuilder, FreezesNormalisersAndTheHalfOnly) {
  const auto graph = *BuildLatentPolicy(SmallOptions());

  for (const v1::Parameter& parameter : graph.parameters()) {
    const bool layer = absl::EndsWith(parameter.name(), "/weight") ||
                       absl::EndsWith(parameter.name(), "/bias");
    EXPECT_EQ(parameter.frozen(), !layer) << parameter.name();
  }
}

TEST(LatentBuilder, ExecutesAndRecordsTheActionWithoutADistribution) {
  const auto graph = *BuildLatentPolicy(SmallOptions());

  for (const v1::Tap& tap : (*FindGraph(graph, "policy"))->taps()) {
    EXPECT_EQ(tap.executed(), tap.name() == "action");
    EXPECT_EQ(tap.recorded(), tap.name() != "latent");
    EXPECT_EQ(tap.distribution_case(), v1::Tap::DISTRIBUTION_NOT_SET);
  }
}

TEST(LatentBuilder, OneThatExploresActsAroundTheDecoderOfItsLatent) {
  const TensorMap weights = LivelyWeights(ExploringOptions());
  const std::vector<float> observation = Normal(51, kObservation);
  const std::vector<float> noise = Normal(52, kLatent);
  const std::vector<float> action_noise = Normal(53, kAction);

  const Values policy = RunGraph("policy", weights,
                                 {{"observation", observation},
                                  {"noise", noise},
                                  {"action_noise", action_noise}},
                                 ExploringOptions());

  EXPECT_EQ(policy.at("latent_noise"), noise);
  EXPECT_EQ(policy.at("mean"),
            RunGraph("decoder", weights,
                     {{"self_observation", OwnColumns(observation)},
                      {"latent", policy.at("latent")}},
                     ExploringOptions())
                .at("action"));
  for (size_t i = 0; i < kRows * kAction; ++i) {
    EXPECT_NEAR(policy.at("action")[i],
                policy.at("mean")[i] + 0.5 * action_noise[i], 1e-5f);
  }
}

TEST(LatentBuilder, WithoutNoiseItExploresNot) {
  const TensorMap weights = LivelyWeights(ExploringOptions());
  const std::vector<float> observation = Normal(61, kObservation);

  const Values policy = RunGraph(
      "policy", weights, {{"observation", observation}}, ExploringOptions());

  EXPECT_EQ(policy.at("action"), policy.at("mean"));
  EXPECT_EQ(policy.at("latent"),
            RunGraph("encoder", weights, {{"observation", observation}},
                     ExploringOptions())
                .at("mean"));
}

TEST(LatentBuilder, OneThatExploresHasAGaussianAndACriticBesideTheSameGraphs) {
  const auto plain = *BuildLatentPolicy(SmallOptions());
  const auto graph = *BuildLatentPolicy(ExploringOptions());

  for (const v1::Tap& tap : (*FindGraph(graph, "policy"))->taps()) {
    EXPECT_EQ(tap.executed(), tap.name() == "action");
    EXPECT_EQ(tap.has_gaussian(), tap.name() == "action");
    EXPECT_EQ(tap.recorded(), tap.name() != "latent");
  }
  for (const char* name : {"encoder", "prior", "decoder", "sample"}) {
    EXPECT_THAT(**FindGraph(graph, name),
                EqualsProto(**FindGraph(plain, name)));
  }
  EXPECT_FALSE(FindGraph(plain, "critic").ok());
  const v1::Graph& critic = **FindGraph(graph, "critic");
  ASSERT_EQ(critic.taps_size(), 1);
  EXPECT_EQ(critic.taps(0).name(), "value");
  EXPECT_EQ(InferWidths(graph, "critic")->at(critic.taps(0).value()), 1);
  // Normalisers are what it shares with the policy.
  const std::set<std::string> policy =
      ParametersOf(**FindGraph(graph, "policy"));
  for (const std::string& name : ParametersOf(critic)) {
    EXPECT_EQ(policy.contains(name), absl::StartsWith(name, "normaliser/"))
        << name;
  }
  const TensorMap weights = *InitialLatentWeights(ExploringOptions(), 1);
  EXPECT_THAT(ValidateGraph(graph, weights), IsOk());
  EXPECT_THAT(weights.at("policy/std").float32(), Each(0.5f));
  for (const v1::Parameter& parameter : graph.parameters()) {
    if (parameter.name() == "policy/std") EXPECT_TRUE(parameter.frozen());
  }
}

TEST(LatentBuilder, InitialWeightsAreAFunctionOfTheSeed) {
  const auto one = *InitialLatentWeights(SmallOptions(), 7);

  EXPECT_EQ(SerializeSafetensors(one),
            SerializeSafetensors(*InitialLatentWeights(SmallOptions(), 7)));
  EXPECT_NE(SerializeSafetensors(one),
            SerializeSafetensors(*InitialLatentWeights(SmallOptions(), 8)));
  EXPECT_THAT(one.at("normaliser/goal/inverse_std").float32(), Each(1));
  EXPECT_THAT(one.at("latent/half").float32(), Each(0.5f));
  EXPECT_THAT(one.at("decoder/action/bias").float32(), Each(0));
}

TEST(LatentBuilder, GainsAreThoseOfTheHeader) {
  const auto weights = *InitialLatentWeights(SmallOptions(), 7);
  const auto norm = [&](const std::string& name) {
    double squares = 0;
    for (const float w : weights.at(name).float32()) squares += w * w;
    return std::sqrt(squares);
  };

  // As many orthonormal vectors as the shorter side has.
  EXPECT_NEAR(norm("encoder/linear_0/weight"), std::sqrt(2.0 * kObservation),
              1e-5);
  EXPECT_NEAR(norm("encoder/mean/weight"), 0.3 * std::sqrt(kLatent), 1e-5);
  EXPECT_NEAR(norm("prior/log_variance/weight"), 0.3 * std::sqrt(kLatent),
              1e-5);
  EXPECT_NEAR(norm("decoder/action/weight"), 0.3 * std::sqrt(kAction), 1e-5);
}

void ExpectRefused(const LatentPolicyOptions& options, const char* message) {
  EXPECT_THAT(BuildLatentPolicy(options),
              StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr(message)));
}

TEST(LatentBuilder, NamesTheOptionThatIsWrong) {
  LatentPolicyOptions options = SmallOptions();
  options.self_observation_width = 0;
  ExpectRefused(options, "self_observation_width: expected >= 1, found 0");
  options = SmallOptions();
  options.observation_width = kSelf;
  ExpectRefused(options,
                "observation_width: expected > self_observation_width (7), "
                "found 7");
  options = SmallOptions();
  options.action_width = -1;
  ExpectRefused(options, "action_width: expected >= 1, found -1");
  options = SmallOptions();
  options.network.clear_latent();
  ExpectRefused(options, "network.latent: expected it to be set");
  options = SmallOptions();
  options.network.set_activation(v1::Network::ACTIVATION_UNSPECIFIED);
  ExpectRefused(options, "network.activation: expected SILU");
  options = SmallOptions();
  options.network.mutable_latent()->set_width(0);
  ExpectRefused(options, "network.latent.width: expected >= 1, found 0");
  options = SmallOptions();
  options.network.mutable_latent()->add_prior_hidden(0);
  ExpectRefused(options, "network.latent.prior_hidden: expected >= 1, found 0");
  options = SmallOptions();
  options.network.mutable_latent()->set_log_variance_low(2);
  ExpectRefused(options,
                "network.latent.log_variance_low: expected < "
                "log_variance_high (2), found 2");
  options = ExploringOptions();
  options.network.set_initial_std(0);
  ExpectRefused(options, "network.initial_std: expected > 0, found 0");
  options = ExploringOptions();
  options.network.add_value_hidden(0);
  ExpectRefused(options, "network.value_hidden: expected >= 1, found 0");
}

}  // namespace
}  // namespace sinew::policy
