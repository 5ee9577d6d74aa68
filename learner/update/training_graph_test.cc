#include "learner/update/training_graph.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "common/policy/builder.h"
#include "common/policy/latent_builder.h"
#include "common/policy/validate.h"
#include "common/testing/matchers.h"

namespace sinew::learner {
namespace {

using ::sinew::testing::IsOk;
using ::sinew::testing::StatusIs;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;

// Widths: observation, of which own, action, latent.
constexpr int kObservation = 6, kOwn = 4, kAction = 2, kLatent = 3;

v1::Network SmallNetwork() {
  v1::Network network;
  network.add_policy_hidden(16);
  network.add_value_hidden(4);
  network.set_activation(v1::Network::ACTIVATION_SILU);
  network.set_last_layer_gain(1);
  network.set_observation_clip(8);
  network.set_initial_std(0.4);
  return network;
}

v1::PolicyGraph LatentGraph(bool explores = false) {
  policy::LatentPolicyOptions options = {.self_observation_width = kOwn,
                                         .observation_width = kObservation,
                                         .action_width = kAction,
                                         .network = SmallNetwork(),
                                         .explores = explores};
  v1::Latent& latent = *options.network.mutable_latent();
  latent.set_width(kLatent);
  latent.set_log_variance_low(-5);
  latent.set_log_variance_high(2);
  return *policy::BuildLatentPolicy(options);
}

v1::PolicyGraph TrackingGraph() {
  return *policy::BuildTrackingPolicy({.observation_width = kObservation,
                                       .action_width = kAction,
                                       .network = SmallNetwork()});
}

TEST(TrainingGraph, JoinsThePolicyAndThePriorOfALatent) {
  const auto graph = MakeTrainingGraph(LatentGraph());

  ASSERT_THAT(graph, IsOk());
  EXPECT_THAT(policy::ValidateGraph(graph->all), IsOk());
  EXPECT_THAT(graph->outputs,
              ElementsAre("action", "posterior_mean", "posterior_log_variance",
                          "prior/prior_mean", "prior/prior_log_variance"));
  EXPECT_EQ(graph->observation_width, kObservation);
  EXPECT_EQ(graph->action_width, kAction);
  EXPECT_EQ(graph->latent_width, kLatent);
  EXPECT_EQ(graph->noise, "noise");
}

// The latent's noise is not the action's, whose mean is read before it.
TEST(TrainingGraph, LeavesExplorationOut) {
  const auto graph = MakeTrainingGraph(LatentGraph(/*explores=*/true));

  ASSERT_THAT(graph, IsOk());
  EXPECT_THAT(policy::ValidateGraph(graph->all), IsOk());
  EXPECT_THAT(graph->outputs,
              ElementsAre("mean", "posterior_mean", "posterior_log_variance",
                          "prior/prior_mean", "prior/prior_log_variance"));
  EXPECT_EQ(graph->noise, "noise");
  EXPECT_EQ(graph->latent_width, kLatent);
  EXPECT_EQ(graph->action_width, kAction);
}

TEST(TrainingGraph, ReadsTheMeanWithoutALatent) {
  const auto bare = WithoutExploration(TrackingGraph());
  ASSERT_THAT(bare, IsOk());

  const auto graph = MakeTrainingGraph(*bare);

  ASSERT_THAT(graph, IsOk());
  EXPECT_THAT(graph->outputs, ElementsAre("mean"));
  EXPECT_EQ(graph->latent_width, 0);
  EXPECT_EQ(graph->noise, "");
}

TEST(TrainingGraph, NeedsTheNoiseOfTheLatent) {
  v1::PolicyGraph graph = LatentGraph();
  v1::Graph& policy = *graph.mutable_graphs(0);
  ASSERT_EQ(policy.name(), "policy");
  for (v1::GraphInput& input : *policy.mutable_inputs()) {
    if (input.name() == "noise") input.set_kind(v1::GraphInput::KIND_DATA);
  }

  EXPECT_THAT(MakeTrainingGraph(graph),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("an input \"noise\" of normal noise")));
}

TEST(TrainingGraph, NeedsTheEncoderThatAPriorBelongsTo) {
  v1::PolicyGraph graph = LatentGraph();
  for (v1::Graph& one : *graph.mutable_graphs()) {
    if (one.name() == "encoder") one.set_name("another");
  }

  EXPECT_THAT(MakeTrainingGraph(graph),
              StatusIs(absl::StatusCode::kNotFound, HasSubstr("encoder")));
}

TEST(WithoutExploration, LeavesThePolicysMeanAlone) {
  const auto bare = WithoutExploration(TrackingGraph());

  ASSERT_THAT(bare, IsOk());
  ASSERT_EQ(bare->graphs_size(), 1);
  const v1::Graph& policy = bare->graphs(0);
  EXPECT_EQ(policy.inputs_size(), 1);
  ASSERT_EQ(policy.taps_size(), 2);
  for (const v1::Tap& tap : policy.taps()) {
    EXPECT_EQ(tap.value(), "mean");
    EXPECT_TRUE(tap.recorded());
    EXPECT_FALSE(tap.has_gaussian());
    EXPECT_EQ(tap.executed(), tap.name() == "action");
  }
  for (const v1::Parameter& parameter : bare->parameters()) {
    EXPECT_THAT(parameter.name(), Not(HasSubstr("critic")));
    EXPECT_NE(parameter.name(), "policy/std");
  }
}

}  // namespace
}  // namespace sinew::learner
