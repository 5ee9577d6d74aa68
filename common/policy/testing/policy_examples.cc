#include <utility>

#include "absl/strings/ascii.h"
#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "common/policy/builder.h"
#include "common/policy/latent_builder.h"
#include "common/policy/testing/example_writer.h"
#include "common/policy/testing/examples.h"
#include "common/random/philox.h"

namespace sinew::policy::testing {
namespace {

// A tracking policy's size: hidden widths of both networks.
struct TrackingSize {
  std::string name;
  int64_t observation_width;
  int64_t action_width;
  std::vector<int32_t> hidden;
};

TrackingPolicyOptions PolicyOptions(const TrackingSize& size,
                                    v1::Network::Activation activation) {
  TrackingPolicyOptions options{.observation_width = size.observation_width,
                                .action_width = size.action_width};
  for (const int32_t width : size.hidden) {
    options.network.add_policy_hidden(width);
    options.network.add_value_hidden(width);
  }
  options.network.set_activation(activation);
  options.network.set_last_layer_gain(0.5);
  options.network.set_observation_clip(2.5);
  options.network.set_initial_std(0.4);
  return options;
}

// Random statistics, as if the normaliser had seen data.
Example Tracking(const TrackingSize& size, v1::Network::Activation activation,
                 const std::string& graph_name) {
  const TrackingPolicyOptions options = PolicyOptions(size, activation);
  Example example;
  example.name =
      absl::StrCat(graph_name, size.name, "_",
                   absl::AsciiStrToLower(
                       v1::Network::Activation_Name(activation).substr(11)));
  example.graph = *BuildTrackingPolicy(options);
  example.graph_name = graph_name;
  example.weights = *InitialWeights(options, 11);
  HostTensor& mean = example.weights.at("normaliser/mean");
  FillNormal({.seed = 12}, mean.mutable_float32());
  HostTensor& inverse_std = example.weights.at("normaliser/inverse_std");
  FillUniform({.seed = 13}, inverse_std.mutable_float32());
  return example;
}

// Random statistics for all normalisers of a policy.
void DrawStatistics(uint64_t seed, TensorMap& weights) {
  for (auto& [name, tensor] : weights) {
    if (!absl::StrContains(name, "normaliser/")) continue;
    if (absl::EndsWith(name, "/mean")) {
      FillNormal({.seed = ++seed}, tensor.mutable_float32());
    } else if (absl::EndsWith(name, "/inverse_std")) {
      FillUniform({.seed = ++seed}, tensor.mutable_float32());
    }
  }
}

// A composer over primitives that differ, normalisers included.
Example Composer(int primitives, std::vector<int32_t> hidden) {
  const TrackingSize size = {"", 40, 7, {33, 24}};
  const TrackingPolicyOptions alone =
      PolicyOptions(size, v1::Network::ACTIVATION_SILU);
  TrackingPolicyOptions options = alone;
  v1::Composer& composer = *options.network.mutable_composer();
  composer.set_primitives(primitives);
  composer.mutable_hidden()->Add(hidden.begin(), hidden.end());
  Example example;
  example.name = absl::StrCat("composer_of_", primitives);
  example.graph = *BuildTrackingPolicy(options);
  example.graph_name = "policy";
  example.weights = *InitialWeights(options, 11);
  for (int k = 0; k < primitives; ++k) {
    const TensorMap weights = *InitialWeights(alone, 20 + k);
    for (const auto& [name, tensor] : weights) {
      const auto found = example.weights.find(PrimitiveParameter(k, name));
      if (found != example.weights.end()) found->second = tensor;
    }
  }
  DrawStatistics(/*seed=*/30, example.weights);
  return example;
}

// What recipe pulse trains for our humanoid, with narrower hidden layers.
LatentPolicyOptions PulseOptions() {
  LatentPolicyOptions options{.self_observation_width = 111,
                              .observation_width = 224,
                              .action_width = 28};
  options.network.set_activation(v1::Network::ACTIVATION_SILU);
  options.network.set_last_layer_gain(0.5);
  options.network.set_observation_clip(2.5);
  v1::Latent& latent = *options.network.mutable_latent();
  latent.set_width(32);
  for (const int32_t width : {256, 100}) {
    latent.add_encoder_hidden(width);
    latent.add_prior_hidden(width);
    latent.add_decoder_hidden(width);
  }
  latent.set_log_variance_low(-5);
  latent.set_log_variance_high(2);
  return options;
}

// One example per graph of a policy with a latent; biases are not 0.
std::vector<Example> LatentPolicy() {
  const v1::PolicyGraph graph = *BuildLatentPolicy(PulseOptions());
  TensorMap weights = *InitialLatentWeights(PulseOptions(), 11);
  DrawStatistics(/*seed=*/50, weights);
  uint64_t seed = 60;
  for (auto& [name, tensor] : weights) {
    if (!absl::EndsWith(name, "/bias")) continue;
    FillNormal({.seed = ++seed}, tensor.mutable_float32());
  }
  std::vector<Example> examples;
  for (const v1::Graph& one : graph.graphs()) {
    examples.push_back({.name = absl::StrCat("latent_", one.name()),
                        .graph = graph,
                        .graph_name = one.name(),
                        .weights = weights});
  }
  return examples;
}

// Our humanoid's widths with one reference frame, and beside it: a robot's with
// one layer, three frames ahead (111 + 3 x 113 columns), five frames with a
// deep network, and a policy without hidden layers.
const TrackingSize kUsualSize = {"", 224, 28, {256, 100}};
const TrackingSize kOtherSizes[] = {
    {"_one_layer", 236, 29, {64}},
    {"_three_frames", 450, 28, {96, 96}},
    {"_five_frames_deep", 676, 28, {80, 64, 48, 33}},
    {"_linear", 17, 3, {}},
};

// Convolutional encoder, quantised and continuous latent, gated decoder.
Example Autoencoder() {
  ExampleWriter writer("autoencoder");
  writer.Input("window", 6 * 20).Input("state", 30).Input("epsilon", 8);
  v1::Node& conv =
      writer.Node("conv", v1::OP_CONV1D, {"window"}, {{10, 6, 5}, {10}});
  conv.set_channels(6);
  conv.set_stride(2);
  conv.set_padding(2);
  writer.Node("conv_elu", v1::OP_ELU, {"conv"});
  writer.Node("latent", v1::OP_LINEAR, {"conv_elu"}, {{16, 100}, {16}});
  writer.Node("latent_mean", v1::OP_SLICE, {"latent"}).set_end(8);
  v1::Node& log_std = writer.Node("log_std", v1::OP_SLICE, {"latent"});
  log_std.set_begin(8);
  log_std.set_end(16);
  writer.Node("std", v1::OP_EXP, {"log_std"});
  writer.Node("noise", v1::OP_MULTIPLY, {"std", "epsilon"});
  writer.Node("sample", v1::OP_ADD, {"latent_mean", "noise"});
  writer.Node("unit", v1::OP_L2_NORMALISE, {"sample"}).set_epsilon(1e-8);
  writer.Node("index", v1::OP_ARGMIN, {"unit"}, {{64, 8}});
  writer.Node("code", v1::OP_GATHER, {"index"}, {{64, 8}});
  writer.Node("rest", v1::OP_SUBTRACT, {"unit", "code"});
  writer.Node("context", v1::OP_CONCAT, {"state", "code", "rest"});
  writer.Node("norm", v1::OP_LAYER_NORM, {"context"}, {{46}, {46}})
      .set_epsilon(1e-5);
  writer.Node("gate_logits", v1::OP_LINEAR, {"norm"}, {{2, 46}, {2}});
  writer.Node("gate", v1::OP_SOFTMAX, {"gate_logits"});
  writer.Node("first", v1::OP_LINEAR, {"norm"}, {{40, 46}, {40}});
  writer.Node("second", v1::OP_LINEAR, {"norm"}, {{40, 46}, {40}});
  writer.Node("mixed", v1::OP_WEIGHTED_SUM, {"gate", "first", "second"});
  writer.Node("squashed", v1::OP_SIGMOID, {"mixed"});
  v1::Node& decoded = writer.Node("decoded", v1::OP_CONV1D_TRANSPOSE,
                                  {"squashed"}, {{4, 3, 4}, {3}});
  decoded.set_channels(4);
  decoded.set_stride(2);
  decoded.set_padding(1);
  writer.Tap("unit_latent", "unit");
  writer.Tap("index_of_code", "index");
  writer.Tap("window_out", "decoded");
  return writer.Finish();
}

std::vector<Example> MakePolicies() {
  std::vector<Example> examples;
  for (const auto activation :
       {v1::Network::ACTIVATION_SILU, v1::Network::ACTIVATION_RELU,
        v1::Network::ACTIVATION_ELU, v1::Network::ACTIVATION_TANH}) {
    examples.push_back(Tracking(kUsualSize, activation, "policy"));
    examples.push_back(Tracking(kUsualSize, activation, "critic"));
  }
  for (const TrackingSize& size : kOtherSizes) {
    examples.push_back(Tracking(size, v1::Network::ACTIVATION_SILU, "policy"));
    examples.push_back(Tracking(size, v1::Network::ACTIVATION_SILU, "critic"));
  }
  examples.push_back(Composer(2, {}));
  examples.push_back(Composer(3, {20, 9}));
  for (Example& example : LatentPolicy()) {
    examples.push_back(std::move(example));
  }
  examples.push_back(Autoencoder());
  return examples;
}

}  // namespace

std::vector<Example> PolicyExamples() {
  // Orthogonal initial weights take a while.
  static const auto* const examples = new std::vector<Example>(MakePolicies());
  return *examples;
}

}  // namespace sinew::policy::testing
