// A policy with a latent that explores: to be learnt by PPO.

#include <set>
#include <string>
#include <vector>

#include "absl/strings/match.h"
#include "common/policy/latent_builder.h"
#include "common/policy/safetensors.h"
#include "common/policy/testing/latent_rig.h"
#include "common/policy/validate.h"
#include "common/testing/matchers.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace sinew::policy {
namespace {

using ::sinew::testing::EqualsProto;
using ::sinew::testing::IsOk;
using ::testing::Each;
using testing::ExploringOptions;
using testing::kAction;
using testing::kLatent;
using testing::kObservation;
using testing::kRows;
using testing::LivelyWeights;
using testing::Normal;
using testing::OwnColumns;
using testing::ParametersOf;
using testing::RunGraph;
using testing::SmallOptions;
using testing::Values;

TEST(LatentExploration, OneThatExploresActsAroundTheDecoderOfItsLatent) {
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

TEST(LatentExploration, WithoutNoiseItExploresNot) {
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

TEST(LatentExploration,
     OneThatExploresHasAGaussianAndACriticBesideTheSameGraphs) {
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

}  // namespace
}  // namespace sinew::policy
