#include "actor/prepared_snapshot.h"

#include <algorithm>
#include <utility>

#include "absl/strings/str_cat.h"
#include "common/policy/ports.h"
#include "common/policy/safetensors.h"
#include "common/policy/validate.h"
#include "common/status_macros.h"

namespace sinew::actor {
namespace {

constexpr absl::string_view kGraph = "policy";

absl::Status Error(absl::string_view what) {
  return absl::InvalidArgumentError(
      absl::StrCat("snapshot graph \"policy\": ", what));
}

absl::Status CheckWidth(absl::string_view what, absl::string_view name,
                        int64_t expected, int64_t found) {
  if (found == expected) return absl::OkStatus();
  return Error(absl::StrCat("expected ", what, " ", name, " of width ",
                            expected, ", found ", found));
}

// What a rollout needs beyond policy::Ports: the Gaussian behind the executed
// tap `ports.action`, which there is.
absl::Status FindGaussian(const v1::Graph& graph, PolicyPorts& ports) {
  const auto& taps = graph.taps();
  const v1::Tap& tap = *std::find_if(
      taps.begin(), taps.end(),
      [&](const v1::Tap& one) { return one.name() == ports.action; });
  if (!tap.has_gaussian() || tap.decision_period() > 1) {
    return Error(absl::StrCat("expected tap ", tap.name(),
                              " to be Gaussian and decided every step"));
  }
  const v1::GaussianTap& gaussian = tap.gaussian();
  const auto mean = std::find_if(
      taps.begin(), taps.end(),
      [&](const v1::Tap& one) { return one.value() == gaussian.mean(); });
  if (mean == taps.end()) {
    return Error(absl::StrCat("expected a tap of node ", gaussian.mean(),
                              ", the mean of ", tap.name()));
  }
  ports.std_parameter = gaussian.std_parameter();
  ports.mean = mean->name();
  return absl::OkStatus();
}

absl::StatusOr<PolicyPorts> FindPolicyPorts(const v1::PolicyGraph& graphs,
                                            const world::TrackingTask& task) {
  const absl::StatusOr<const v1::Graph*> graph =
      policy::FindGraph(graphs, kGraph);
  // A snapshot without it is wrong, not out of reach.
  if (!graph.ok()) return Error(graph.status().message());
  SINEW_ASSIGN_OR_RETURN(policy::Ports found,
                         policy::FindPorts(graphs, kGraph));
  SINEW_RETURN_IF_ERROR(CheckWidth("input", found.observation,
                                   task.observation_width(),
                                   found.observation_width));
  SINEW_RETURN_IF_ERROR(
      CheckWidth("tap", found.action, task.action_width(), found.action_width));
  PolicyPorts ports;
  ports.observation = std::move(found.observation);
  ports.noise = std::move(found.noise);
  ports.action = std::move(found.action);
  SINEW_RETURN_IF_ERROR(FindGaussian(**graph, ports));
  return ports;
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
  std::shared_ptr<PreparedSnapshot> prepared(
      new PreparedSnapshot(std::move(starts)));
  prepared->version_ = snapshot.version();
  prepared->sha256_ = sha256;
  SINEW_ASSIGN_OR_RETURN(prepared->ports_,
                         FindPolicyPorts(snapshot.graph(), task));
  SINEW_ASSIGN_OR_RETURN(
      prepared->pack_, policy::PackWeights(snapshot.graph(), kGraph, weights));
  SINEW_ASSIGN_OR_RETURN(
      prepared->std_,
      ReadStd(weights, prepared->ports_.std_parameter, task.action_width()));
  return prepared;
}

}  // namespace sinew::actor
