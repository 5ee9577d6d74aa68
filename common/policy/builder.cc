#include "common/policy/builder.h"

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
#include "common/policy/layers.h"
#include "common/policy/validate.h"
#include "common/status_macros.h"

namespace sinew::policy {
namespace {

using internal::ActivationOp;
using internal::Bad;
using internal::CheckPositive;
using internal::CheckWidth;
using internal::CheckWidths;
using internal::GraphWriter;
using internal::Value;

absl::Status CheckComposer(const v1::Composer& composer) {
  if (composer.primitives() < kFewestPrimitives ||
      composer.primitives() > kMostPrimitives) {
    return Bad("network.composer.primitives: expected ", kFewestPrimitives,
               " to ", kMostPrimitives, ", found ", composer.primitives());
  }
  return CheckWidths("network.composer.hidden", composer.hidden());
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
  SINEW_RETURN_IF_ERROR(
      CheckWidths("network.policy_hidden", network.policy_hidden()));
  SINEW_RETURN_IF_ERROR(
      CheckWidths("network.value_hidden", network.value_hidden()));
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
  const Value clipped = internal::AddNormalised(
      {.name = "observation", .width = options.observation_width}, part.prefix,
      part.prefix + "normaliser/", network.observation_clip(), writer);
  const std::string layers = part.prefix + part.layers;
  const Value hidden =
      internal::AddHidden(clipped,
                          {.widths = part.hidden,
                           .activation = *ActivationOp(network.activation()),
                           .nodes = part.prefix,
                           .layers = layers,
                           .frozen = part.frozen},
                          writer);
  writer.Linear(part.prefix + part.last, hidden.name,
                absl::StrCat(layers, "/", part.last),
                {part.width, hidden.width}, part.frozen);
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
  internal::AddExploration("noise", options.action_width, writer);
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
  const v1::Network& network = options.network;
  return internal::DrawWeights(
      graph, seed,
      {.gain = [&](const std::string& name) { return Gain(name, network); },
       .constant =
           [&](const std::string& name) {
             return InitialConstant(name, network);
           }});
}

bool IsComposerParameter(absl::string_view name) {
  return absl::StartsWith(name, "composer/");
}

std::string PrimitiveParameter(int primitive, absl::string_view name) {
  return absl::StrCat("primitive_", primitive, "/", name);
}

}  // namespace sinew::policy
