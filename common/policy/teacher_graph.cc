#include "common/policy/teacher_graph.h"

#include <set>
#include <string>

#include "absl/strings/str_cat.h"
#include "common/policy/graph_error.h"
#include "common/policy/validate.h"
#include "common/status_macros.h"

namespace sinew::policy {
namespace {

using internal::At;
using internal::Bad;

std::string Prefixed(const std::string& name) {
  return absl::StrCat(kTeacherPrefix, name);
}

// Renames the parameters of a graph; gives their former names.
std::set<std::string> Rename(v1::Graph& graph) {
  std::set<std::string> names;
  const auto rename = [&](std::string& name) {
    names.insert(name);
    name = Prefixed(name);
  };
  for (v1::Node& node : *graph.mutable_nodes()) {
    for (std::string& name : *node.mutable_parameters()) rename(name);
  }
  for (v1::Tap& tap : *graph.mutable_taps()) {
    if (!tap.has_gaussian()) continue;
    rename(*tap.mutable_gaussian()->mutable_std_parameter());
  }
  return names;
}

}  // namespace

absl::Status AddTeacherGraph(const v1::PolicyGraph& teacher,
                             const TensorMap& teacher_weights,
                             v1::PolicyGraph& graph, TensorMap& weights) {
  SINEW_RETURN_IF_ERROR(At("teacher", ValidateGraph(teacher, teacher_weights)));
  const absl::StatusOr<const v1::Graph*> policy = FindGraph(teacher, "policy");
  if (!policy.ok()) return Bad("teacher: ", policy.status().message());
  if (FindGraph(graph, kTeacherGraph).ok()) {
    return Bad("expected no graph named ", kTeacherGraph, ", found one");
  }
  v1::Graph& added = *graph.add_graphs();
  added = **policy;
  added.set_name(std::string(kTeacherGraph));
  const std::set<std::string> names = Rename(added);
  for (const v1::Parameter& parameter : teacher.parameters()) {
    if (!names.contains(parameter.name())) continue;
    v1::Parameter& copy = *graph.add_parameters();
    copy = parameter;
    copy.set_name(Prefixed(parameter.name()));
    copy.set_frozen(true);
    weights[copy.name()] = teacher_weights.at(parameter.name());
  }
  return absl::OkStatus();
}

}  // namespace sinew::policy
