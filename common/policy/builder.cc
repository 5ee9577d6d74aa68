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
#include "common/policy/graph_error.h"
#include "common/policy/orthogonal.h"
#include "common/policy/validate.h"
#include "common/random/philox.h"
#include "common/status_macros.h"

namespace sinew::policy {
namespace {

using internal::Bad;

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
  return ActivationOp(network.activation()).status();
}

// Adds nodes to one graph, and the parameters that they name.
class GraphWriter {
 public:
  GraphWriter(v1::PolicyGraph& all, v1::Graph& graph)
      : all_(all), graph_(graph) {}

  void Input(const std::string& name, int64_t width,
             v1::GraphInput::Kind kind) {
    v1::GraphInput* input = graph_.add_inputs();
    input->set_name(name);
    input->set_width(width);
    input->set_kind(kind);
  }

  v1::Node& Node(const std::string& name, v1::Op op,
                 absl::Span<const std::string> inputs,
                 absl::Span<const std::string> parameters = {}) {
    v1::Node* node = graph_.add_nodes();
    node->set_name(name);
    node->set_op(op);
    for (const std::string& input : inputs) node->add_inputs(input);
    for (const std::string& one : parameters) node->add_parameters(one);
    return *node;
  }

  // Shared by name: a parameter that exists already is left alone.
  void Parameter(const std::string& name, absl::Span<const int64_t> shape,
                 bool frozen) {
    for (const v1::Parameter& known : all_.parameters()) {
      if (known.name() == name) return;
    }
    v1::Parameter* parameter = all_.add_parameters();
    parameter->set_name(name);
    parameter->mutable_shape()->Add(shape.begin(), shape.end());
    parameter->set_frozen(frozen);
  }

  void Linear(const std::string& name, const std::string& input,
              const std::string& prefix, int64_t in, int64_t out) {
    const std::string weight = prefix + "/weight";
    const std::string bias = prefix + "/bias";
    Parameter(weight, {out, in}, /*frozen=*/false);
    Parameter(bias, {out}, /*frozen=*/false);
    Node(name, v1::OP_LINEAR, {input}, {weight, bias});
  }

  v1::Tap& Tap(const std::string& name) {
    v1::Tap* tap = graph_.add_taps();
    tap->set_name(name);
    tap->set_value(name);
    return *tap;
  }

 private:
  v1::PolicyGraph& all_;
  v1::Graph& graph_;
};

// From the observation to the last, linear layer, which is called `output`.
void AddNetwork(const TrackingPolicyOptions& options,
                absl::Span<const int32_t> hidden, const std::string& prefix,
                const std::string& output, int64_t output_width,
                GraphWriter& writer) {
  const v1::Network& network = options.network;
  const v1::Op activation = *ActivationOp(network.activation());
  int64_t width = options.observation_width;
  writer.Input("observation", width, v1::GraphInput::KIND_DATA);
  writer.Parameter("normaliser/mean", {width}, /*frozen=*/true);
  writer.Parameter("normaliser/inverse_std", {width}, /*frozen=*/true);
  writer.Node("normalised", v1::OP_NORMALISE, {"observation"},
              {"normaliser/mean", "normaliser/inverse_std"});
  v1::Node& clamp = writer.Node("clipped", v1::OP_CLAMP, {"normalised"});
  clamp.set_low(-network.observation_clip());
  clamp.set_high(network.observation_clip());
  std::string last = "clipped";
  for (size_t i = 0; i < hidden.size(); ++i) {
    const std::string name = absl::StrCat("hidden_", i);
    writer.Linear(name, last, absl::StrCat(prefix, "/linear_", i), width,
                  hidden[i]);
    last = name + "_activation";
    writer.Node(last, activation, {name});
    width = hidden[i];
  }
  writer.Linear(output, last, absl::StrCat(prefix, "/", output), width,
                output_width);
}

void AddPolicy(const TrackingPolicyOptions& options, v1::PolicyGraph& all) {
  v1::Graph& graph = *all.add_graphs();
  graph.set_name("policy");
  GraphWriter writer(all, graph);
  AddNetwork(options, options.network.policy_hidden(), "policy", "mean",
             options.action_width, writer);
  writer.Input("noise", options.action_width, v1::GraphInput::KIND_NORMAL);
  writer.Parameter("policy/std", {options.action_width}, /*frozen=*/true);
  writer.Node("exploration", v1::OP_AFFINE, {"noise"}, {"policy/std"});
  writer.Node("action", v1::OP_ADD, {"mean", "exploration"});
  v1::Tap& action = writer.Tap("action");
  action.set_executed(true);
  action.set_recorded(true);
  action.mutable_gaussian()->set_mean("mean");
  action.mutable_gaussian()->set_std_parameter("policy/std");
  writer.Tap("mean").set_recorded(true);
}

void AddCritic(const TrackingPolicyOptions& options, v1::PolicyGraph& all) {
  v1::Graph& graph = *all.add_graphs();
  graph.set_name("critic");
  GraphWriter writer(all, graph);
  AddNetwork(options, options.network.value_hidden(), "critic", "value",
             /*output_width=*/1, writer);
  writer.Tap("value");
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
  if (weight == "policy/mean/weight") return network.last_layer_gain();
  if (weight == "critic/value/weight") return 1.0;
  return std::numbers::sqrt2;
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
    if (absl::EndsWith(name, "/weight")) {
      const RandomKey key = {.seed = seed,
                             .environment = static_cast<uint64_t>(i),
                             .purpose = RandomPurpose::kInitialisation};
      weights[name] = OrthogonalWeight(shape[0], shape[1],
                                       Gain(name, options.network), key);
    } else if (name == "policy/std") {
      weights[name] = Constant(shape, options.network.initial_std());
    } else {
      weights[name] = Constant(shape, name == "normaliser/inverse_std");
    }
  }
  return weights;
}

}  // namespace sinew::policy
