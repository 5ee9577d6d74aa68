#include "learner/trainer/policy_snapshot.h"

#include "common/digest.h"

namespace sinew::learner {

v1::PolicyGraph SelectGraphs(const v1::PolicyGraph& graph,
                             const std::set<std::string>& keep) {
  v1::PolicyGraph result;
  result.set_format_version(graph.format_version());
  std::set<std::string> used;
  for (const v1::Graph& one : graph.graphs()) {
    if (!keep.contains(one.name())) continue;
    *result.add_graphs() = one;
    for (const v1::Node& node : one.nodes()) {
      used.insert(node.parameters().begin(), node.parameters().end());
    }
    for (const v1::Tap& tap : one.taps()) {
      if (tap.has_gaussian()) used.insert(tap.gaussian().std_parameter());
    }
  }
  for (const v1::Parameter& parameter : graph.parameters()) {
    if (used.contains(parameter.name())) *result.add_parameters() = parameter;
  }
  return result;
}

TensorMap SelectWeights(const v1::PolicyGraph& graph,
                        const TensorMap& weights) {
  TensorMap result;
  for (const v1::Parameter& parameter : graph.parameters()) {
    const auto it = weights.find(parameter.name());
    if (it != weights.end()) result.insert(*it);
  }
  return result;
}

PublishedSnapshot MakePolicySnapshot(int64_t version,
                                     const v1::PolicyGraph& graph,
                                     const TensorMap& weights,
                                     const v1::CurriculumTable& curriculum) {
  PublishedSnapshot result;
  result.snapshot.set_version(version);
  *result.snapshot.mutable_graph() = SelectGraphs(graph, {"policy"});
  result.snapshot.set_weights(
      SerializeSafetensors(SelectWeights(result.snapshot.graph(), weights)));
  *result.snapshot.mutable_curriculum() = curriculum;
  result.bytes = SerializeDeterministically(result.snapshot);
  result.sha256 = Sha256Hex(result.bytes);
  return result;
}

}  // namespace sinew::learner
