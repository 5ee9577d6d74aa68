#include "common/policy/builder.h"

#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/string_view.h"
#include "absl/types/span.h"
#include "common/config/recipe.h"
#include "common/policy/graph_error.h"
#include "common/policy/graph_writer.h"
#include "common/policy/orthogonal.h"
#include "common/policy/validate.h"
#include "common/random/philox.h"
#include "common/status_macros.h"

namespace sinew::policy {
namespace {

using internal::Bad;
using internal::GraphWriter;

absl::StatusOr<v1::Op> ActivationOp(v1::Network::Activation activation) {
  switch (activation) {
    case v1::Network::ACTIVATION_SILU:
      return v1::OP_SILU;
    case v1::Network::ACTIVATION_RELU:
      return v1::OP_RELU;
    case v1::Network::ACTIVATION_ELU:
      return v1::OP_ELU;
    case v1::Network::ACTIVATION_TANH:
      return v1::OP_TANH;
    default:
      return Bad("network.activation: expected SILU, RELU, ELU or TANH, found ",
                 static_cast<int>(activation));
  }
}

absl::Status CheckPositive(absl::string_view name, double value) {
  if (value > 0 && std::isfinite(value)) return absl::OkStatus();
  return Bad(name, ": expected > 0, found ", value);
}

absl::Status CheckWidth(absl::string_view name, int64_t width) {
  if (width >= 1) return absl::OkStatus();
  return Bad(name, ": expected >= 1, found ", width);
}

absl::Status CheckComposer(const v1::Composer& composer) {
  if (composer.primitives() < kFewestPrimitives ||
      composer.primitives() > kMostPrimitives) {
    return Bad("network.composer.primitives: expected ", kFewestPrimitives,
               " to ", kMostPrimitives, ", found ", composer.primitives());
  }
  for (const int32_t width : composer.hidden()) {
    SINEW_RETURN_IF_ERROR(CheckWidth("network.composer.hidden", width));
  }
  return absl::OkStatus();
}

absl::Status CheckOptions(const TrackingPolicyOptions& options) {
  const v1::Network& network = options.network;
  SINEW_RETURN_IF_ERROR(
      CheckWidth("observation_width", options.observation_width));
  SINEW_RETURN_IF_ERROR(CheckWidth("action_width", options.action_width));
  SINEW_RETURN_IF_ERROR(
      CheckPositive("network.observation_clip", network.observation_clip()));
  SINEW_RETURN_IF_ERROR(
      CheckPositive("network.initial_std", network.initial_std()));
  SINEW_RETURN_IF_ERROR(
      CheckPositive("network.last_layer_gain", network.last_layer_gain()));
  for (const int32_t width : network.policy_hidden()) {
    SINEW_RETURN_IF_ERROR(CheckWidth("network.policy_hidden", width));
  }
  for (const int32_t width : network.value_hidden()) {
    SINEW_RETURN_IF_ERROR(CheckWidth("network.value_hidden", width));
  }
  if (network.has_composer()) {
    SINEW_RETURN_IF_ERROR(CheckComposer(network.composer()));
  }
  return ActivationOp(network.activation()).status();
}

// One network: from the observation to its last, linear layer.
struct Part {
  absl::Span<const int32_t> hidden;
  std::string layers;  // its parameters: LAYERS/linear_i/..., LAYERS/LAST/...
  std::string last;    // name of the last node
  int64_t width = 0;   // of it
  std::string prefix = {};  // before all its names
  bool frozen = false;
};

void AddNetwork(const TrackingPolicyOptions& options, const Part& part,
                GraphWriter& writer) {
  const v1::Network& network = options.network;
  const v1::Op activation = *ActivationOp(network.activation());
  int64_t width = options.observation_width;
  const std::string mean = part.prefix + "normaliser/mean";
  const std::string inverse_std = part.prefix + "normaliser/inverse_std";
  writer.Parameter(mean, {width}, /*frozen=*/true);
  writer.Parameter(inverse_std, {width}, /*frozen=*/true);
  const std::string normalised = part.prefix + "normalised";
  writer.Node(normalised, v1::OP_NORMALISE, {"observation"},
              {mean, inverse_std});
  std::string value = part.prefix + "clipped";
  v1::Node& clamp = writer.Node(value, v1::OP_CLAMP, {normalised});
  clamp.set_low(-network.observation_clip());
  clamp.set_high(network.observation_clip());
  const std::string layers = part.prefix + part.layers;
  for (size_t i = 0; i < part.hidden.size(); ++i) {
    const std::string name = absl::StrCat(part.prefix, "hidden_", i);
    writer.Linear(name, value, absl::StrCat(layers, "/linear_", i),
                  {part.hidden[i], width}, part.frozen);
    value = name + "_activation";
    writer.Node(value, activation, {name});
    width = part.hidden[i];
  }
  writer.Linear(part.prefix + part.last, value,
                absl::StrCat(layers, "/", part.last), {part.width, width},
                part.frozen);
}

// The node "mean" of a composer and its primitives.
void AddComposedMean(const TrackingPolicyOptions& options,
                     GraphWriter& writer) {
  const v1::Composer& composer = options.network.composer();
  AddNetwork(options,
             {.hidden = composer.hidden(),
              .layers = "composer",
              .last = "weights",
              .width = composer.primitives()},
             writer);
  std::vector<std::string> inputs = {"weights"};
  for (int k = 0; k < composer.primitives(); ++k) {
    const std::string prefix = PrimitiveParameter(k, "");
    AddNetwork(options,
               {.hidden = options.network.policy_hidden(),
                .layers = "policy",
                .last = "mean",
                .width = options.action_width,
                .prefix = prefix,
                .frozen = true},
               writer);
    inputs.push_back(prefix + "mean");
  }
  writer.Node("mean", v1::OP_WEIGHTED_SUM, inputs);
}

void AddPolicy(const TrackingPolicyOptions& options, v1::PolicyGraph& all) {
  v1::Graph& graph = *all.add_graphs();
  graph.set_name("policy");
  GraphWriter writer(all, graph);
  writer.Input("observation", options.observation_width,
               v1::GraphInput::KIND_DATA);
  if (options.network.has_composer()) {
    AddComposedMean(options, writer);
  } else {
    AddNetwork(options,
               {.hidden = options.network.policy_hidden(),
                .layers = "policy",
                .last = "mean",
                .width = options.action_width},
               writer);
  }
  writer.Input("noise", options.action_width, v1::GraphInput::KIND_NORMAL);
  writer.Parameter("policy/std", {options.action_width}, /*frozen=*/true);
  writer.Node("exploration", v1::OP_AFFINE, {"noise"}, {"policy/std"});
  writer.Node("action", v1::OP_ADD, {"mean", "exploration"});
  v1::Tap& action = writer.Tap("action", "action");
  action.set_executed(true);
  action.set_recorded(true);
  action.mutable_gaussian()->set_mean("mean");
  action.mutable_gaussian()->set_std_parameter("policy/std");
  writer.Tap("mean", "mean").set_recorded(true);
  if (options.network.has_composer()) writer.Tap("composer_weights", "weights");
}

void AddCritic(const TrackingPolicyOptions& options, v1::PolicyGraph& all) {
  v1::Graph& graph = *all.add_graphs();
  graph.set_name("critic");
  GraphWriter writer(all, graph);
  writer.Input("observation", options.observation_width,
               v1::GraphInput::KIND_DATA);
  AddNetwork(options,
             {.hidden = options.network.value_hidden(),
              .layers = "critic",
              .last = "value",
              .width = 1},
             writer);
  writer.Tap("value", "value");
}

HostTensor Constant(const std::vector<int64_t>& shape, double value) {
  HostTensor tensor = HostTensor::Zeros(shape);
  for (float& element : tensor.mutable_float32()) {
    element = static_cast<float>(value);
  }
  return tensor;
}

// Gain of a layer's orthogonal weight.
double Gain(const std::string& weight, const v1::Network& network) {
  if (weight == "policy/mean/weight" || weight == "composer/weights/weight") {
    return network.last_layer_gain();
  }
  if (weight == "critic/value/weight") return 1.0;
  return std::numbers::sqrt2;
}

// Of all elements of a parameter that is not drawn.
double InitialConstant(const std::string& name, const v1::Network& network) {
  if (name == "policy/std") return network.initial_std();
  if (name == "composer/weights/bias") {
    return 1.0 / network.composer().primitives();
  }
  return absl::EndsWith(name, "normaliser/inverse_std") ? 1.0 : 0.0;
}

}  // namespace

absl::StatusOr<v1::PolicyGraph> BuildTrackingPolicy(
    const TrackingPolicyOptions& options) {
  SINEW_RETURN_IF_ERROR(CheckOptions(options));
  v1::PolicyGraph graph;
  graph.set_format_version(1);
  AddPolicy(options, graph);
  AddCritic(options, graph);
  SINEW_RETURN_IF_ERROR(ValidateGraph(graph));
  return graph;
}

absl::StatusOr<TensorMap> InitialWeights(const TrackingPolicyOptions& options,
                                         uint64_t seed) {
  SINEW_ASSIGN_OR_RETURN(const v1::PolicyGraph graph,
                         BuildTrackingPolicy(options));
  TensorMap weights;
  for (int i = 0; i < graph.parameters_size(); ++i) {
    const std::string& name = graph.parameters(i).name();
    const std::vector<int64_t> shape(graph.parameters(i).shape().begin(),
                                     graph.parameters(i).shape().end());
    if (absl::EndsWith(name, "/weight") && !graph.parameters(i).frozen()) {
      const RandomKey key = {.seed = seed,
                             .environment = static_cast<uint64_t>(i),
                             .purpose = RandomPurpose::kInitialisation};
      weights[name] = OrthogonalWeight(shape[0], shape[1],
                                       Gain(name, options.network), key);
    } else {
      weights[name] = Constant(shape, InitialConstant(name, options.network));
    }
  }
  return weights;
}

bool IsComposerParameter(absl::string_view name) {
  return absl::StartsWith(name, "composer/");
}

std::string PrimitiveParameter(int primitive, absl::string_view name) {
  return absl::StrCat("primitive_", primitive, "/", name);
}

}  // namespace sinew::policy
