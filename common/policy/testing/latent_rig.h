#ifndef SINEW_COMMON_POLICY_TESTING_LATENT_RIG_H_
#define SINEW_COMMON_POLICY_TESTING_LATENT_RIG_H_

#include <algorithm>
#include <cstdint>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "absl/strings/match.h"
#include "absl/types/span.h"
#include "common/policy/executor.h"
#include "common/policy/latent_builder.h"
#include "common/policy/safetensors.h"
#include "common/policy/validate.h"
#include "common/random/philox.h"
#include "gtest/gtest.h"
#include "proto/sinew/v1/graph.pb.h"

namespace sinew::policy::testing {

// What tests of policies with a latent share: small networks, weights in which
// everything matters, and what their graphs compute for a few rows.

inline constexpr int kRows = 3, kSelf = 7, kObservation = 12, kAction = 5,
                     kLatent = 4;

inline LatentPolicyOptions SmallOptions() {
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
inline LatentPolicyOptions ExploringOptions() {
  LatentPolicyOptions options = SmallOptions();
  options.explores = true;
  options.network.add_value_hidden(6);
  options.network.set_initial_std(0.5);
  return options;
}

// Initial weights with normalisers and biases that do something.
inline TensorMap LivelyWeights(
    const LatentPolicyOptions& options = SmallOptions()) {
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
inline Values RunGraph(const std::string& name, const TensorMap& weights,
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

inline std::vector<float> Normal(uint64_t seed, int width) {
  std::vector<float> values(kRows * width);
  FillNormal({.seed = seed}, absl::MakeSpan(values));
  return values;
}

// The first kSelf columns of observations.
inline std::vector<float> OwnColumns(const std::vector<float>& observations) {
  std::vector<float> own;
  for (int row = 0; row < kRows; ++row) {
    const auto* begin = observations.data() + row * kObservation;
    own.insert(own.end(), begin, begin + kSelf);
  }
  return own;
}

inline std::set<std::string> ParametersOf(const v1::Graph& graph) {
  std::set<std::string> names;
  for (const v1::Node& node : graph.nodes()) {
    names.insert(node.parameters().begin(), node.parameters().end());
  }
  return names;
}

}  // namespace sinew::policy::testing

#endif  // SINEW_COMMON_POLICY_TESTING_LATENT_RIG_H_
