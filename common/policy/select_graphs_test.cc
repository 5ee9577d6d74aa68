#include "common/policy/select_graphs.h"

#include <string>
#include <vector>

#include "common/config/recipe.h"
#include "common/policy/builder.h"
#include "common/policy/validate.h"
#include "common/testing/matchers.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace sinew::policy {
namespace {

using ::sinew::testing::EqualsProto;
using ::sinew::testing::IsOk;
using ::testing::Each;
using ::testing::ElementsAre;
using ::testing::IsSupersetOf;
using ::testing::Not;
using ::testing::StartsWith;

TrackingPolicyOptions Options() {
  return {.observation_width = 5,
          .action_width = 2,
          .network = WithDefaults(v1::Recipe()).network()};
}

// Policy, critic, and a copy of the policy named "teacher" whose layers it
// shares.
v1::PolicyGraph ThreeGraphs() {
  v1::PolicyGraph graph = *BuildTrackingPolicy(Options());
  const v1::Graph policy = graph.graphs(0);
  *graph.add_graphs() = policy;
  graph.mutable_graphs(2)->set_name("teacher");
  return graph;
}

std::vector<std::string> GraphNames(const v1::PolicyGraph& graph) {
  std::vector<std::string> names;
  for (const v1::Graph& one : graph.graphs()) names.push_back(one.name());
  return names;
}

std::vector<std::string> ParameterNames(const v1::PolicyGraph& graph) {
  std::vector<std::string> names;
  for (const v1::Parameter& one : graph.parameters()) {
    names.push_back(one.name());
  }
  return names;
}

TEST(GraphsWithout, LeavesOutGraphsAndTheParametersOfTheseAlone) {
  const v1::PolicyGraph all = ThreeGraphs();
  const TensorMap weights = *InitialWeights(Options(), /*seed=*/1);

  const v1::PolicyGraph kept = GraphsWithout(all, {"critic"});

  EXPECT_THAT(GraphNames(kept), ElementsAre("policy", "teacher"));
  EXPECT_THAT(kept.graphs(0), EqualsProto(all.graphs(0)));
  EXPECT_THAT(ParameterNames(kept), Each(Not(StartsWith("critic/"))));
  EXPECT_THAT(
      ParameterNames(kept),
      IsSupersetOf({"normaliser/mean", "policy/mean/bias", "policy/std"}));
  EXPECT_THAT(ValidateGraph(kept, WeightsOf(kept, weights)), IsOk());
}

TEST(GraphsWithout, KeepsWhatIsShared) {
  const v1::PolicyGraph all = ThreeGraphs();

  EXPECT_EQ(ParameterNames(GraphsWithout(all, {"critic", "teacher"})),
            ParameterNames(GraphsWithout(all, {"critic"})));
}

TEST(GraphsWithout, ChangesNothingIfNoGraphHasTheName) {
  const v1::PolicyGraph all = ThreeGraphs();

  EXPECT_THAT(GraphsWithout(all, {"encoder"}), EqualsProto(all));
}

TEST(WeightsOf, TakesTheTensorsOfTheParametersThatThereAre) {
  const v1::PolicyGraph kept = GraphsWithout(ThreeGraphs(), {"critic"});
  TensorMap weights = *InitialWeights(Options(), /*seed=*/1);
  weights.erase("policy/std");

  const TensorMap own = WeightsOf(kept, weights);

  EXPECT_EQ(own.size(), ParameterNames(kept).size() - 1);
  EXPECT_FALSE(own.contains("critic/value/bias"));
  EXPECT_EQ(own.at("policy/mean/weight").data,
            weights.at("policy/mean/weight").data);
}

}  // namespace
}  // namespace sinew::policy
