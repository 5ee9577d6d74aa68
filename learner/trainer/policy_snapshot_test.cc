#include "learner/trainer/policy_snapshot.h"

#include <string>
#include <vector>

#include "common/config/recipe.h"
#include "common/digest.h"
#include "common/policy/builder.h"
#include "common/testing/matchers.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace sinew::learner {
namespace {

using ::sinew::testing::EqualsProto;
using ::sinew::testing::IsOk;
using ::testing::ElementsAre;

// The graphs of a learner: policy, critic and two more that share the policy's
// parameters.
struct Learnt {
  Learnt() {
    const policy::TrackingPolicyOptions options = {
        .observation_width = 5,
        .action_width = 2,
        .network = WithDefaults(v1::Recipe()).network()};
    graph = *policy::BuildTrackingPolicy(options);
    weights = *policy::InitialWeights(options, /*seed=*/1);
    const v1::Graph acting = graph.graphs(0);
    for (const char* name : {"prior", "teacher"}) {
      *graph.add_graphs() = acting;
      graph.mutable_graphs(graph.graphs_size() - 1)->set_name(name);
    }
  }
  v1::PolicyGraph graph;
  TensorMap weights;
};

TEST(PolicySnapshot, HasAllGraphsButTheCritic) {
  const Learnt learnt;

  const PublishedSnapshot made =
      MakePolicySnapshot(7, learnt.graph, learnt.weights, {});

  std::vector<std::string> names;
  for (const v1::Graph& graph : made.snapshot.graph().graphs()) {
    names.push_back(graph.name());
  }
  EXPECT_THAT(names, ElementsAre("policy", "prior", "teacher"));
  EXPECT_EQ(made.snapshot.version(), 7);
}

TEST(PolicySnapshot, HasTheWeightsOfItsGraphsAlone) {
  const Learnt learnt;

  const PublishedSnapshot made =
      MakePolicySnapshot(7, learnt.graph, learnt.weights, {});

  const auto weights = ParseSafetensors(made.snapshot.weights(), "snapshot");
  ASSERT_THAT(weights, IsOk());
  EXPECT_EQ(weights->size(),
            static_cast<size_t>(made.snapshot.graph().parameters_size()));
  EXPECT_TRUE(weights->contains("policy/mean/weight"));
  EXPECT_FALSE(weights->contains("critic/value/weight"));
}

TEST(PolicySnapshot, IsDigestedAsItIsSent) {
  const Learnt learnt;
  v1::CurriculumTable curriculum;

  const PublishedSnapshot made =
      MakePolicySnapshot(7, learnt.graph, learnt.weights, curriculum);

  v1::Snapshot sent;
  ASSERT_TRUE(sent.ParseFromString(made.bytes));
  EXPECT_THAT(sent, EqualsProto(made.snapshot));
  EXPECT_EQ(made.sha256, Sha256Hex(made.bytes));
}

}  // namespace
}  // namespace sinew::learner
