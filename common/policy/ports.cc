#include "common/policy/ports.h"

#include <map>

#include "absl/strings/str_cat.h"
#include "common/policy/validate.h"
#include "common/status_macros.h"

namespace sinew::policy {
namespace {

absl::Status Error(const v1::Graph& graph, absl::string_view expected,
                   absl::string_view found) {
  return absl::InvalidArgumentError(absl::StrCat(
      "graph \"", graph.name(), "\": expected ", expected, ", found ", found));
}

absl::Status FindInputs(const v1::Graph& graph, Ports& ports) {
  for (const v1::GraphInput& input : graph.inputs()) {
    if (input.kind() == v1::GraphInput::KIND_NORMAL) {
      ports.noise.push_back(input.name());
    } else if (input.kind() != v1::GraphInput::KIND_DATA) {
      return Error(graph, "data and normal inputs",
                   absl::StrCat("\"", input.name(), "\" of ",
                                v1::GraphInput::Kind_Name(input.kind())));
    } else if (!ports.observation.empty()) {
      return Error(graph, "one data input",
                   absl::StrCat("\"", ports.observation, "\" and \"",
                                input.name(), "\""));
    } else {
      ports.observation = input.name();
      ports.observation_width = input.width();
    }
  }
  if (ports.observation.empty()) return Error(graph, "a data input", "none");
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<Ports> FindPorts(const v1::PolicyGraph& graph,
                                absl::string_view graph_name) {
  SINEW_ASSIGN_OR_RETURN(const v1::Graph* one, FindGraph(graph, graph_name));
  SINEW_ASSIGN_OR_RETURN((const std::map<std::string, int64_t> widths),
                         InferWidths(graph, graph_name));
  Ports ports;
  SINEW_RETURN_IF_ERROR(FindInputs(*one, ports));
  for (const v1::Tap& tap : one->taps()) {
    if (!tap.executed()) continue;
    if (!ports.action.empty()) {
      return Error(
          *one, "one executed tap",
          absl::StrCat("\"", ports.action, "\" and \"", tap.name(), "\""));
    }
    ports.action = tap.name();
    ports.action_width = widths.at(tap.value());
  }
  if (ports.action.empty()) return Error(*one, "an executed tap", "none");
  return ports;
}

}  // namespace sinew::policy
