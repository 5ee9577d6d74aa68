#include "common/policy/select_graphs.h"

namespace sinew::policy {
namespace {

void AddUsed(const v1::Graph& graph, std::set<std::string>& used) {
  for (const v1::Node& node : graph.nodes()) {
    used.insert(node.parameters().begin(), node.parameters().end());
  }
  for (const v1::Tap& tap : graph.taps()) {
    if (tap.has_gaussian()) used.insert(tap.gaussian().std_parameter());
  }
}

}  // namespace

v1::PolicyGraph GraphsWithout(const v1::PolicyGraph& graph,
                              const std::set<std::string>& left_out) {
  v1::PolicyGraph result;
  result.set_format_version(graph.format_version());
  std::set<std::string> used;
  for (const v1::Graph& one : graph.graphs()) {
    if (left_out.contains(one.name())) continue;
    *result.add_graphs() = one;
    AddUsed(one, used);
  }
  for (const v1::Parameter& parameter : graph.parameters()) {
    if (used.contains(parameter.name())) *result.add_parameters() = parameter;
  }
  return result;
}

TensorMap WeightsOf(const v1::PolicyGraph& graph, const TensorMap& weights) {
  TensorMap result;
  for (const v1::Parameter& parameter : graph.parameters()) {
    const auto found = weights.find(parameter.name());
    if (found != weights.end()) result.insert(*found);
  }
  return result;
}

}  // namespace sinew::policy
