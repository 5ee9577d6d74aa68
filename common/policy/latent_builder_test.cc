#include "common/policy/latent_builder.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <string>
#include <vector>

#include "absl/strings/match.h"
#include "common/policy/executor.h"
#include "common/policy/safetensors.h"
#include "common/policy/testing/latent_rig.h"
#include "common/policy/validate.h"
#include "common/testing/matchers.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace sinew::policy {
namespace {

using ::sinew::testing::IsOk;
using ::sinew::testing::StatusIs;
using ::testing::ElementsAre;
using testing::ExploringOptions;
using ::testing::HasSubstr;
using testing::kLatent;
using testing::kObservation;
using testing::kRows;
using testing::kSelf;
using testing::LivelyWeights;
using testing::Normal;
using testing::OwnColumns;
using testing::ParametersOf;
using testing::RunGraph;
using testing::SmallOptions;
using testing::Values;

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
