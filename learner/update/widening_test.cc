#include "learner/update/widening.h"

#include <vector>

#include "common/policy/builder.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace sinew::learner {
namespace {

using ::testing::ElementsAre;

v1::PolicyGraph Graph() {
  policy::TrackingPolicyOptions options{.observation_width = 6,
                                        .action_width = 2};
  v1::Network& network = options.network;
  network.add_policy_hidden(5);
  network.add_policy_hidden(4);
  network.add_value_hidden(3);
  network.set_activation(v1::Network::ACTIVATION_SILU);
  network.set_last_layer_gain(0.01);
  network.set_observation_clip(8);
  network.set_initial_std(0.4);
  return *policy::BuildTrackingPolicy(options);
}

TEST(HiddenWidths, AreThoseBetweenLayersAndNoOthers) {
  struct Case {
    const char* name;
    std::vector<int64_t> narrow;
    std::vector<int64_t> wide;
    bool can;
  };
  const Case cases[] = {
      {"policy/linear_0/weight", {3, 6}, {5, 6}, true},
      {"policy/linear_0/weight", {5, 6}, {5, 6}, true},
      {"policy/linear_0/weight", {5, 5}, {5, 6}, false},  // the observation
      {"policy/linear_0/weight", {7, 6}, {5, 6}, false},  // no narrowing
      {"policy/linear_0/weight", {5}, {5, 6}, false},
      {"policy/linear_0/bias", {3}, {5}, true},
      {"policy/linear_1/weight", {3, 3}, {4, 5}, true},
      {"policy/linear_1/weight", {5, 3}, {4, 5}, false},
      {"policy/mean/weight", {2, 3}, {2, 4}, true},
      {"policy/mean/weight", {1, 4}, {2, 4}, false},  // the action
      {"policy/mean/bias", {1}, {2}, false},
      {"policy/std", {1}, {2}, false},
      {"normaliser/mean", {5}, {6}, false},
      {"critic/linear_0/weight", {2, 6}, {3, 6}, true},
      {"critic/value/weight", {1, 2}, {1, 3}, true},
  };
  const HiddenWidths hidden(Graph());
  for (const Case& one : cases) {
    EXPECT_EQ(hidden.CanWiden(one.name, HostTensor::Zeros(one.narrow),
                              HostTensor::Zeros(one.wide)),
              one.can)
        << one.name << " " << ::testing::PrintToString(one.narrow);
  }
}

TEST(HiddenWidths, StayWhereAnotherGraphUsesTheLayerOtherwise) {
  v1::PolicyGraph graph = Graph();
  v1::Graph& other = *graph.add_graphs();
  other = graph.graphs(0);
  other.set_name("other");
  other.add_taps()->set_value("hidden_0");

  const HiddenWidths hidden(graph);

  EXPECT_FALSE(hidden.CanWiden("policy/linear_0/weight",
                               HostTensor::Zeros({3, 6}),
                               HostTensor::Zeros({5, 6})));
  EXPECT_FALSE(hidden.CanWiden("policy/linear_1/weight",
                               HostTensor::Zeros({4, 3}),
                               HostTensor::Zeros({4, 5})));
  EXPECT_TRUE(hidden.CanWiden("policy/mean/weight", HostTensor::Zeros({2, 3}),
                              HostTensor::Zeros({2, 4})));
}

TEST(Widen, KeepsNewRowsAndSilencesNewColumnsOfOldOnes) {
  HostTensor wide = HostTensor::Float32({3, 3}, {9, 9, 9, 9, 9, 9, 9, 9, 9});
  Widen(HostTensor::Float32({2, 2}, {1, 2, 3, 4}), wide);
  EXPECT_THAT(wide.float32(), ElementsAre(1, 2, 0, 3, 4, 0, 9, 9, 9));

  HostTensor bias = HostTensor::Float32({3}, {9, 9, 9});
  Widen(HostTensor::Float32({1}, {5}), bias);
  EXPECT_THAT(bias.float32(), ElementsAre(5, 9, 9));
}

}  // namespace
}  // namespace sinew::learner
