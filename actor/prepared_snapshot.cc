#include "actor/prepared_snapshot.h"

#include <algorithm>
#include <map>
#include <utility>

#include "absl/strings/str_cat.h"
#include "common/policy/latent_graphs.h"
#include "common/policy/ports.h"
#include "common/policy/safetensors.h"
#include "common/policy/teacher_graph.h"
#include "common/policy/validate.h"
#include "common/segment/segment_layout.h"
#include "common/status_macros.h"

namespace sinew::actor {
namespace {

constexpr absl::string_view kPolicyGraph = "policy";

absl::Status Error(absl::string_view graph, absl::string_view what) {
  return absl::InvalidArgumentError(
      absl::StrCat("snapshot graph \"", graph, "\": ", what));
}

absl::Status CheckWidth(absl::string_view graph, absl::string_view what,
                        absl::string_view name, int64_t expected,
                        int64_t found) {
  if (found == expected) return absl::OkStatus();
  return Error(graph, absl::StrCat("expected ", what, " ", name, " of width ",
                                   expected, ", found ", found));
}

template <typename Predicate>
const v1::Tap* FindTap(const v1::Graph& graph, Predicate&& wanted) {
  const auto& taps = graph.taps();
  const auto found = std::find_if(taps.begin(), taps.end(), wanted);
  return found == taps.end() ? nullptr : &*found;
}

// What a graph that acts must be like.
struct Role {
  absl::string_view graph;
  int observation_width;
  bool has_mean;  // else the action is its own
};

// What a rollout needs beyond policy::Ports: the mean behind the executed tap
// `ports.action`, which there is, and its deviation.
absl::Status FindMean(const v1::Graph& graph, bool has_mean,
                      PolicyPorts& ports) {
  const v1::Tap& tap = *FindTap(
      graph, [&](const v1::Tap& one) { return one.name() == ports.action; });
  if (tap.has_categorical() || tap.decision_period() > 1) {
    return Error(graph.name(),
                 absl::StrCat("expected tap ", tap.name(),
                              " to be Gaussian or without distribution, and "
                              "decided every step"));
  }
  const bool gaussian = tap.has_gaussian();
  if (!gaussian && !has_mean) {
    ports.mean = ports.action;
    return absl::OkStatus();
  }
  const v1::Tap* mean = FindTap(graph, [&](const v1::Tap& one) {
    return gaussian ? one.value() == tap.gaussian().mean()
                    : one.name() == "mean";
  });
  if (mean == nullptr) {
    return Error(
        graph.name(),
        gaussian
            ? absl::StrCat("expected a tap of node ", tap.gaussian().mean(),
                           ", the mean of ", tap.name())
            : absl::StrCat("expected a tap named mean beside ", tap.name(),
                           ", which has no distribution"));
  }
  ports.mean = mean->name();
  ports.std_parameter = tap.gaussian().std_parameter();
  return absl::OkStatus();
}

// Ports and widths of a graph that acts.
absl::Status FindPolicyPorts(const v1::PolicyGraph& graphs, const Role& role,
                             const world::TrackingTask& task,
                             ActingGraph& acting) {
  const absl::string_view name = role.graph;
  const absl::StatusOr<const v1::Graph*> graph =
      policy::FindGraph(graphs, name);
  // A snapshot without it is wrong, not out of reach.
  if (!graph.ok()) return Error(name, graph.status().message());
  SINEW_ASSIGN_OR_RETURN(policy::Ports found, policy::FindPorts(graphs, name));
  SINEW_RETURN_IF_ERROR(CheckWidth(name, "input", found.observation,
                                   role.observation_width,
                                   found.observation_width));
  SINEW_RETURN_IF_ERROR(CheckWidth(name, "tap", found.action,
                                   task.action_width(), found.action_width));
  PolicyPorts& ports = acting.ports;
  ports.observation = std::move(found.observation);
  ports.noise = std::move(found.noise);
  ports.action = std::move(found.action);
  SINEW_RETURN_IF_ERROR(FindMean(**graph, role.has_mean, ports));
  SINEW_ASSIGN_OR_RETURN((const std::map<std::string, int64_t> widths),
                         policy::InferWidths(graphs, name));
  const v1::Tap& mean = *FindTap(
      **graph, [&](const v1::Tap& one) { return one.name() == ports.mean; });
  SINEW_RETURN_IF_ERROR(CheckWidth(name, "tap", ports.mean, task.action_width(),
                                   widths.at(mean.value())));
  const v1::Tap* noise = FindTap(**graph, [](const v1::Tap& one) {
    return one.name() == column::kLatentNoise;
  });
  if (noise == nullptr) return absl::OkStatus();
  ports.latent_noise = noise->name();
  acting.latent_noise_width = static_cast<int>(widths.at(noise->value()));
  return absl::OkStatus();
}

absl::StatusOr<std::vector<double>> ReadStd(const TensorMap& weights,
                                            absl::string_view graph,
                                            const std::string& name,
                                            int action_width) {
  const auto found = weights.find(name);
  if (found == weights.end() || found->second.dtype != v1::DATA_TYPE_FLOAT32 ||
      found->second.num_elements() != action_width) {
    return Error(graph, absl::StrCat("expected float32 parameter ", name,
                                     " of ", action_width, " elements"));
  }
  std::vector<double> std;
  for (float value : found->second.float32()) {
    if (!(value > 0)) {
      return Error(graph, absl::StrCat("expected parameter ", name,
                                       " to be > 0, found ", value));
    }
    std.push_back(value);
  }
  return std;
}

absl::StatusOr<ActingGraph> MakeActing(const v1::PolicyGraph& graphs,
                                       const Role& role,
                                       const TensorMap& weights,
                                       const world::TrackingTask& task) {
  ActingGraph acting;
  acting.action_width = task.action_width();
  SINEW_RETURN_IF_ERROR(FindPolicyPorts(graphs, role, task, acting));
  SINEW_ASSIGN_OR_RETURN(acting.pack,
                         policy::PackWeights(graphs, role.graph, weights));
  const std::string& std = acting.ports.std_parameter;
  if (!std.empty()) {
    SINEW_ASSIGN_OR_RETURN(
        acting.std, ReadStd(weights, role.graph, std, acting.action_width));
  }
  return acting;
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
  const int width = task.observation_width();
  const auto make = [&](const Role& role) {
    return MakeActing(snapshot.graph(), role, weights, task);
  };
  const auto wanted = [&](double share, absl::string_view graph) {
    return share > 0 && policy::FindGraph(snapshot.graph(), graph).ok();
  };
  SINEW_ASSIGN_OR_RETURN(prepared->policy_, make({.graph = kPolicyGraph,
                                                  .observation_width = width,
                                                  .has_mean = true}));
  const v1::Distillation& shares = assets.recipe().distillation();
  if (wanted(shares.teacher_share(), policy::kTeacherGraph)) {
    SINEW_ASSIGN_OR_RETURN(prepared->teacher_,
                           make({.graph = policy::kTeacherGraph,
                                 .observation_width = width,
                                 .has_mean = true}));
  }
  if (wanted(shares.prior_share(), policy::kSampleGraph)) {
    SINEW_ASSIGN_OR_RETURN(
        prepared->prior_,
        make({.graph = policy::kSampleGraph,
              .observation_width = task.self_observation_width(),
              .has_mean = false}));
  }
  return prepared;
}

}  // namespace sinew::actor
