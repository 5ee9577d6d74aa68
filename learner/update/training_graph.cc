#include "learner/update/training_graph.h"

#include <map>
#include <utility>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "common/policy/select_graphs.h"
#include "common/policy/validate.h"
#include "common/status_macros.h"

namespace sinew::learner {
namespace {

constexpr char kTraining[] = "training";
constexpr char kObservation[] = "observation";
constexpr char kNoise[] = "noise";  // of the latent
constexpr char kSelf[] = "self_observation";

std::string InPrior(const std::string& name) {
  return absl::StrCat("prior/", name);
}

absl::StatusOr<std::string> TapValue(const v1::Graph& graph,
                                     const std::string& name) {
  for (const v1::Tap& tap : graph.taps()) {
    if (tap.name() == name) return tap.value();
  }
  return absl::InvalidArgumentError(absl::StrCat(
      "graph ", graph.name(), ": expected a tap \"", name, "\", found none"));
}

const v1::GraphInput* FindInput(const v1::Graph& graph,
                                const std::string& name) {
  for (const v1::GraphInput& input : graph.inputs()) {
    if (input.name() == name) return &input;
  }
  return nullptr;
}

bool HasGraph(const v1::PolicyGraph& graph, const std::string& name) {
  return policy::FindGraph(graph, name).ok();
}

// The prior's nodes, behind a slice of the observation.
absl::Status AddPrior(const v1::Graph& prior, v1::Graph& graph) {
  const v1::GraphInput* self = FindInput(prior, kSelf);
  if (prior.inputs_size() != 1 || self == nullptr) {
    return absl::InvalidArgumentError(
        absl::StrCat("graph prior: expected the one input \"", kSelf,
                     "\", found ", prior.inputs_size(), " inputs"));
  }
  v1::Node& slice = *graph.add_nodes();
  slice.set_name(InPrior(kSelf));
  slice.set_op(v1::OP_SLICE);
  slice.add_inputs(kObservation);
  slice.set_begin(0);
  slice.set_end(self->width());
  for (const v1::Node& node : prior.nodes()) {
    v1::Node& copy = *graph.add_nodes();
    copy = node;
    copy.set_name(InPrior(node.name()));
    for (std::string& input : *copy.mutable_inputs()) input = InPrior(input);
  }
  return absl::OkStatus();
}

// Outputs and noise of a policy with a latent, into `result`.
absl::Status AddLatent(const v1::PolicyGraph& graph, v1::Graph& joined,
                       TrainingGraph& result) {
  SINEW_ASSIGN_OR_RETURN(const v1::Graph* encoder,
                         policy::FindGraph(graph, "encoder"));
  SINEW_ASSIGN_OR_RETURN(const v1::Graph* prior,
                         policy::FindGraph(graph, "prior"));
  SINEW_RETURN_IF_ERROR(AddPrior(*prior, joined));
  for (const char* tap : {"mean", "log_variance"}) {
    SINEW_ASSIGN_OR_RETURN(std::string value, TapValue(*encoder, tap));
    result.outputs.push_back(std::move(value));
  }
  for (const char* tap : {"mean", "log_variance"}) {
    SINEW_ASSIGN_OR_RETURN(const std::string value, TapValue(*prior, tap));
    result.outputs.push_back(InPrior(value));
  }
  const v1::GraphInput* noise = FindInput(joined, kNoise);
  if (noise == nullptr || noise->kind() != v1::GraphInput::KIND_NORMAL) {
    return absl::InvalidArgumentError(
        absl::StrCat("graph policy: expected an input \"", kNoise,
                     "\" of normal noise for the latent, found none"));
  }
  result.noise = noise->name();
  result.latent_width = noise->width();
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<TrainingGraph> MakeTrainingGraph(const v1::PolicyGraph& graph) {
  SINEW_ASSIGN_OR_RETURN(const v1::Graph* policy,
                         policy::FindGraph(graph, "policy"));
  TrainingGraph result;
  result.all = graph;
  result.name = kTraining;
  v1::Graph& joined = *result.all.add_graphs();
  joined = *policy;
  joined.set_name(kTraining);
  const v1::GraphInput* observation = FindInput(joined, kObservation);
  if (observation == nullptr) {
    return absl::InvalidArgumentError(absl::StrCat(
        "graph policy: expected an input \"", kObservation, "\", found none"));
  }
  result.observation_width = observation->width();
  SINEW_ASSIGN_OR_RETURN(std::string mean, TapValue(joined, "mean"));
  result.outputs.push_back(std::move(mean));
  if (HasGraph(graph, "prior")) {
    SINEW_RETURN_IF_ERROR(AddLatent(graph, joined, result));
  }
  // ValidateGraph, which names what the actor's taps lack, is the back end's.
  using Widths = std::map<std::string, int64_t>;
  SINEW_ASSIGN_OR_RETURN(const Widths widths,
                         policy::InferWidths(result.all, kTraining));
  for (const std::string& output : result.outputs) {
    if (widths.contains(output)) continue;
    return absl::InvalidArgumentError(
        absl::StrCat("graph policy: expected a node \"", output,
                     "\", as the encoder has, found none"));
  }
  result.action_width = widths.at(result.outputs[0]);
  return result;
}

absl::StatusOr<v1::PolicyGraph> WithoutExploration(
    const v1::PolicyGraph& graph) {
  SINEW_ASSIGN_OR_RETURN(const v1::Graph* policy,
                         policy::FindGraph(graph, "policy"));
  SINEW_ASSIGN_OR_RETURN(const std::string mean, TapValue(*policy, "mean"));
  v1::PolicyGraph all;
  all.set_format_version(graph.format_version());
  *all.mutable_parameters() = graph.parameters();
  v1::Graph& bare = *all.add_graphs();
  bare.set_name("policy");
  for (const v1::GraphInput& input : policy->inputs()) {
    if (input.kind() == v1::GraphInput::KIND_DATA) *bare.add_inputs() = input;
  }
  for (const v1::Node& node : policy->nodes()) {
    *bare.add_nodes() = node;
    if (node.name() == mean) break;
  }
  for (const char* name : {"action", "mean"}) {
    v1::Tap& tap = *bare.add_taps();
    tap.set_name(name);
    tap.set_value(mean);
    tap.set_recorded(true);
    tap.set_executed(std::string(name) == "action");
  }
  // With the parameters that are still used.
  v1::PolicyGraph result = policy::GraphsWithout(all, {});
  SINEW_RETURN_IF_ERROR(policy::ValidateGraph(result));
  return result;
}

}  // namespace sinew::learner
