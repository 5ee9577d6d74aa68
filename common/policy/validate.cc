#include "common/policy/validate.h"

#include <cmath>
#include <set>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "absl/strings/string_view.h"
#include "common/policy/graph_error.h"
#include "common/policy/ops.h"
#include "common/policy/validate_taps.h"
#include "common/status_macros.h"

namespace sinew::policy {
namespace {

using internal::At;
using internal::Bad;
using internal::CheckName;
using internal::Quoted;

using Widths = std::map<std::string, int64_t>;
using Shapes = std::map<std::string, std::vector<int64_t>>;

absl::StatusOr<Shapes> ParameterShapes(const v1::PolicyGraph& graph) {
  Shapes shapes;
  for (const v1::Parameter& parameter : graph.parameters()) {
    SINEW_RETURN_IF_ERROR(At("parameter", CheckName(parameter.name())));
    const std::string where = absl::StrCat("parameter ", parameter.name());
    int64_t elements = 1;
    for (const int64_t extent : parameter.shape()) {
      if (extent < 1 || extent > kMaxParameterElements / elements) {
        return Bad(where, ": expected extents >= 1 and at most ",
                   kMaxParameterElements, " elements, found [",
                   absl::StrJoin(parameter.shape(), ", "), "]");
      }
      elements *= extent;
    }
    const bool fresh =
        shapes
            .try_emplace(parameter.name(), parameter.shape().begin(),
                         parameter.shape().end())
            .second;
    if (!fresh) return Bad(where, ": appears twice");
  }
  return shapes;
}

absl::Status AddInputs(const v1::Graph& graph, Widths& widths) {
  for (const v1::GraphInput& input : graph.inputs()) {
    SINEW_RETURN_IF_ERROR(At("input", CheckName(input.name())));
    const std::string where = absl::StrCat("input ", input.name());
    if (input.kind() != v1::GraphInput::KIND_DATA &&
        input.kind() != v1::GraphInput::KIND_NORMAL &&
        input.kind() != v1::GraphInput::KIND_UNIFORM) {
      return Bad(where, ": expected kind DATA, NORMAL or UNIFORM, found ",
                 static_cast<int>(input.kind()));
    }
    if (input.width() < 1 || input.width() > kMaxWidth) {
      return Bad(where, ": expected a width in [1, ", kMaxWidth, "], found ",
                 input.width());
    }
    if (!widths.emplace(input.name(), input.width()).second) {
      return Bad(where, ": appears twice");
    }
  }
  return absl::OkStatus();
}

absl::StatusOr<int64_t> WidthOfNode(const v1::Node& node, const Shapes& shapes,
                                    const Widths& widths) {
  std::vector<int64_t> inputs;
  for (const std::string& input : node.inputs()) {
    const auto found = widths.find(input);
    if (found == widths.end()) {
      return Bad("expected an input or an earlier node, found ", Quoted(input));
    }
    inputs.push_back(found->second);
  }
  std::vector<std::vector<int64_t>> parameters;
  for (const std::string& parameter : node.parameters()) {
    const auto found = shapes.find(parameter);
    if (found == shapes.end()) {
      return Bad("expected a declared parameter, found ", Quoted(parameter));
    }
    parameters.push_back(found->second);
  }
  return NodeWidth(node, inputs, parameters);
}

absl::Status AddNodes(const v1::Graph& graph, const Shapes& shapes,
                      Widths& widths) {
  for (const v1::Node& node : graph.nodes()) {
    SINEW_RETURN_IF_ERROR(At("node", CheckName(node.name())));
    const std::string where =
        absl::StrCat("node ", node.name(), " (", v1::Op_Name(node.op()), ")");
    if (widths.contains(node.name())) return Bad(where, ": appears twice");
    const absl::StatusOr<int64_t> width = WidthOfNode(node, shapes, widths);
    SINEW_RETURN_IF_ERROR(At(where, width.status()));
    widths.emplace(node.name(), *width);
  }
  return absl::OkStatus();
}

absl::StatusOr<Widths> CheckGraph(const v1::Graph& graph,
                                  const Shapes& shapes) {
  Widths widths;
  const std::string where = absl::StrCat("graph ", graph.name());
  SINEW_RETURN_IF_ERROR(At(where, AddInputs(graph, widths)));
  SINEW_RETURN_IF_ERROR(At(where, AddNodes(graph, shapes, widths)));
  SINEW_RETURN_IF_ERROR(At(where, internal::CheckTaps(graph, shapes, widths)));
  int64_t total = 0;
  for (const auto& [name, width] : widths) total += width;
  if (total > kMaxTotalWidth) {
    return Bad(where, ": expected widths that add up to at most ",
               kMaxTotalWidth, ", found ", total);
  }
  return widths;
}

absl::Status CheckWeights(const v1::PolicyGraph& graph,
                          const TensorMap& weights) {
  for (const v1::Parameter& parameter : graph.parameters()) {
    const std::vector<int64_t> shape(parameter.shape().begin(),
                                     parameter.shape().end());
    const std::string where =
        absl::StrCat("weights: parameter ", parameter.name());
    const auto found = weights.find(parameter.name());
    if (found == weights.end()) return Bad(where, ": missing");
    const HostTensor& tensor = found->second;
    if (tensor.dtype != v1::DATA_TYPE_FLOAT32) {
      return Bad(where, ": expected FLOAT32, found ",
                 v1::DataType_Name(tensor.dtype));
    }
    if (tensor.shape != shape) {
      return Bad(where, ": expected shape [", absl::StrJoin(shape, ", "),
                 "], found [", absl::StrJoin(tensor.shape, ", "), "]");
    }
    if (tensor.data.size() != tensor.num_elements() * sizeof(float)) {
      return Bad(where, ": expected ", tensor.num_elements() * sizeof(float),
                 " bytes, found ", tensor.data.size());
    }
  }
  return absl::OkStatus();
}

absl::Status CheckDeviations(const v1::Graph& graph, const TensorMap& weights) {
  for (const v1::Tap& tap : graph.taps()) {
    if (!tap.has_gaussian()) continue;
    const std::string& name = tap.gaussian().std_parameter();
    for (const float std : weights.at(name).float32()) {
      if (std > 0 && std::isfinite(std)) continue;
      return Bad("graph ", graph.name(), ": tap ", tap.name(), ": parameter ",
                 name, ": expected finite standard deviations > 0, found ",
                 std);
    }
  }
  return absl::OkStatus();
}

}  // namespace

absl::Status ValidateGraph(const v1::PolicyGraph& graph) {
  if (graph.format_version() != 1) {
    return Bad("format_version: expected 1, found ", graph.format_version());
  }
  SINEW_ASSIGN_OR_RETURN(const Shapes shapes, ParameterShapes(graph));
  std::set<std::string> names;
  for (const v1::Graph& one : graph.graphs()) {
    SINEW_RETURN_IF_ERROR(At("graph", CheckName(one.name())));
    if (!names.insert(one.name()).second) {
      return Bad("graph ", one.name(), ": appears twice");
    }
    SINEW_RETURN_IF_ERROR(CheckGraph(one, shapes).status());
  }
  return absl::OkStatus();
}

absl::Status ValidateGraph(const v1::PolicyGraph& graph,
                           const TensorMap& weights) {
  SINEW_RETURN_IF_ERROR(ValidateGraph(graph));
  SINEW_RETURN_IF_ERROR(CheckWeights(graph, weights));
  for (const v1::Graph& one : graph.graphs()) {
    SINEW_RETURN_IF_ERROR(CheckDeviations(one, weights));
  }
  return absl::OkStatus();
}

absl::StatusOr<const v1::Graph*> FindGraph(const v1::PolicyGraph& graph,
                                           absl::string_view graph_name) {
  std::vector<absl::string_view> names;
  for (const v1::Graph& one : graph.graphs()) {
    if (one.name() == graph_name) return &one;
    names.push_back(one.name());
  }
  return absl::NotFoundError(absl::StrCat("expected a graph named ",
                                          Quoted(graph_name), ", found [",
                                          absl::StrJoin(names, ", "), "]"));
}

absl::StatusOr<std::map<std::string, int64_t>> InferWidths(
    const v1::PolicyGraph& graph, absl::string_view graph_name) {
  SINEW_ASSIGN_OR_RETURN(const v1::Graph* one, FindGraph(graph, graph_name));
  SINEW_ASSIGN_OR_RETURN(const Shapes shapes, ParameterShapes(graph));
  return CheckGraph(*one, shapes);
}

}  // namespace sinew::policy
