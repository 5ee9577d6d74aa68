#include "learner/distillation/training_graph.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "common/policy/builder.h"
#include "common/policy/validate.h"
#include "common/testing/matchers.h"
#include "learner/distillation/student_networks.h"
#include "learner/distillation/testing/student_recipe.h"

namespace sinew::learner {
namespace {

using ::sinew::testing::IsOk;
using ::sinew::testing::StatusIs;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;

v1::PolicyGraph LatentGraph() {
  return MakeStudent(StudentRecipe(), kObservation, kOwn, kAction)->graph;
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

TEST(TrainingGraph, RegressesTheMeanWithoutALatent) {
  const auto student =
      MakeStudent(PlainStudentRecipe(), kObservation, kOwn, kAction);
  ASSERT_THAT(student, IsOk());

  const auto graph = MakeTrainingGraph(student->graph);

  ASSERT_THAT(graph, IsOk());
  EXPECT_THAT(graph->outputs, ElementsAre("mean"));
  EXPECT_EQ(graph->latent_width, 0);
  EXPECT_EQ(graph->noise, "");
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
  const policy::TrackingPolicyOptions options = {
      .observation_width = kObservation,
      .action_width = kAction,
      .network = PlainStudentRecipe().network()};
  const auto explores = policy::BuildTrackingPolicy(options);
  ASSERT_THAT(explores, IsOk());

  const auto bare = WithoutExploration(*explores);

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
