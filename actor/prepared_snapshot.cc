#include "actor/prepared_snapshot.h"

#include <cmath>
#include <utility>

#include "absl/strings/str_cat.h"
#include "common/policy/safetensors.h"
#include "common/status_macros.h"

namespace sinew::actor {
namespace {

constexpr absl::string_view kGraph = "policy";

absl::Status Error(absl::string_view what) {
  return absl::InvalidArgumentError(
      absl::StrCat("snapshot graph \"policy\": ", what));
}

absl::StatusOr<const v1::Graph*> FindGraph(const v1::PolicyGraph& graphs) {
  for (const v1::Graph& graph : graphs.graphs()) {
    if (graph.name() == kGraph) return &graph;
  }
  return Error("expected to be there, found no such graph");
}

absl::Status FindInputs(const v1::Graph& graph, int64_t observation_width,
                        PolicyPorts& ports) {
  for (const v1::GraphInput& input : graph.inputs()) {
    if (input.kind() == v1::GraphInput::KIND_NORMAL) {
      ports.noise.push_back(input.name());
    } else if (input.kind() != v1::GraphInput::KIND_DATA) {
      return Error(absl::StrCat("expected data and normal inputs, found input ",
                                input.name(), " of kind ",
                                v1::GraphInput::Kind_Name(input.kind())));
    } else if (!ports.observation.empty()) {
      return Error(absl::StrCat("expected one data input, found ",
                                ports.observation, " and ", input.name()));
    } else if (input.width() != observation_width) {
      return Error(absl::StrCat("expected input ", input.name(), " of width ",
                                observation_width, ", found ", input.width()));
    } else {
      ports.observation = input.name();
    }
  }
  if (ports.observation.empty()) return Error("expected a data input");
  return absl::OkStatus();
}

absl::Status FindTaps(const v1::Graph& graph, PolicyPorts& ports) {
  const v1::Tap* executed = nullptr;
  for (const v1::Tap& tap : graph.taps()) {
    if (!tap.executed()) continue;
    if (executed != nullptr) {
      return Error(absl::StrCat("expected one executed tap, found ",
                                executed->name(), " and ", tap.name()));
    }
    executed = &tap;
  }
  if (executed == nullptr) return Error("expected an executed tap");
  if (!executed->has_gaussian() || executed->decision_period() > 1) {
    return Error(absl::StrCat("expected tap ", executed->name(),
                              " to be Gaussian and decided every step"));
  }
  ports.action = executed->name();
  ports.std_parameter = executed->gaussian().std_parameter();
  for (const v1::Tap& tap : graph.taps()) {
    if (tap.value() == executed->gaussian().mean()) ports.mean = tap.name();
  }
  if (ports.mean.empty()) {
    return Error(absl::StrCat("expected a tap of node ",
                              executed->gaussian().mean(), ", the mean of ",
                              executed->name()));
  }
  return absl::OkStatus();
}

absl::StatusOr<std::vector<double>> ReadStd(const TensorMap& weights,
                                            const std::string& name,
                                            int action_width) {
  const auto found = weights.find(name);
  if (found == weights.end() || found->second.dtype != v1::DATA_TYPE_FLOAT32 ||
      found->second.num_elements() != action_width) {
    return Error(absl::StrCat("expected float32 parameter ", name, " of ",
                              action_width, " elements"));
  }
  std::vector<double> std;
  for (float value : found->second.float32()) {
    if (!(value > 0)) {
      return Error(absl::StrCat("expected parameter ", name,
                                " to be > 0, found ", value));
    }
    std.push_back(value);
  }
  return std;
}

absl::Status CheckActionWidth(const v1::PolicyGraph& graphs,
                              const v1::Graph& graph, const PolicyPorts& ports,
                              int action_width) {
  SINEW_ASSIGN_OR_RETURN((std::map<std::string, int64_t> widths),
                         policy::InferWidths(graphs, kGraph));
  for (const v1::Tap& tap : graph.taps()) {
    if (tap.name() == ports.action && widths[tap.value()] != action_width) {
      return Error(absl::StrCat("expected tap ", tap.name(), " of width ",
                                action_width, " (joints), found ",
                                widths[tap.value()]));
    }
  }
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<std::shared_ptr<const PreparedSnapshot>>
PreparedSnapshot::Create(const v1::Snapshot& snapshot,
                         const std::string& sha256,
                         const RolloutAssets& assets) {
  const world::TrackingTask& task = assets.task();
  SINEW_ASSIGN_OR_RETURN(
      world::StartTable starts,
      world::StartTable::Create(assets.recipe().task().start(), task.library(),
                                snapshot.curriculum()));
  SINEW_ASSIGN_OR_RETURN(
      TensorMap weights,
      ParseSafetensors(snapshot.weights(), "snapshot weights"));
  SINEW_RETURN_IF_ERROR(CheckFinite(weights, "snapshot weights"));
  SINEW_ASSIGN_OR_RETURN(const v1::Graph* graph, FindGraph(snapshot.graph()));
  std::shared_ptr<PreparedSnapshot> prepared(
      new PreparedSnapshot(std::move(starts)));
  prepared->version_ = snapshot.version();
  prepared->sha256_ = sha256;
  PolicyPorts& ports = prepared->ports_;
  SINEW_RETURN_IF_ERROR(FindInputs(*graph, task.observation_width(), ports));
  SINEW_RETURN_IF_ERROR(FindTaps(*graph, ports));
  SINEW_ASSIGN_OR_RETURN(
      prepared->pack_, policy::PackWeights(snapshot.graph(), kGraph, weights));
  SINEW_RETURN_IF_ERROR(
      CheckActionWidth(snapshot.graph(), *graph, ports, task.action_width()));
  SINEW_ASSIGN_OR_RETURN(prepared->std_, ReadStd(weights, ports.std_parameter,
                                                 task.action_width()));
  return prepared;
}

absl::StatusOr<std::shared_ptr<const PreparedSnapshot>> PrepareSnapshot(
    const v1::Snapshot& snapshot, const std::string& sha256,
    const RolloutAssets& assets) {
  return PreparedSnapshot::Create(snapshot, sha256, assets);
}

}  // namespace sinew::actor
