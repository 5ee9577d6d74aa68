#include "common/policy/onnx/onnx_writer.h"

#include <cstdint>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "common/digest.h"
#include "common/policy/onnx/onnx_graph.h"
#include "common/policy/onnx/onnx_ops.h"
#include "common/policy/validate.h"
#include "common/status_macros.h"
#include "onnx/onnx_pb.h"

namespace sinew::policy {
namespace {

using Shapes = std::map<std::string, std::vector<int64_t>>;
using Widths = std::map<std::string, int64_t>;
using Locations = std::map<std::string, TensorLocation>;

// Opset 17 is the first with LayerNormalization; IR version 8 is its own.
constexpr int kOpset = 17;
constexpr int kIrVersion = 8;

// A plain name: external data must lie beside the model.
absl::Status CheckFileName(absl::string_view name) {
  const bool plain = !name.empty() && name != "." && name != ".." &&
                     name.find_first_of("/\\") == name.npos;
  if (plain) return absl::OkStatus();
  return absl::InvalidArgumentError(absl::StrCat(
      "weights_file: expected a file name without folder, found \"", name,
      "\""));
}

absl::StatusOr<TensorLocation> Locate(const std::string& parameter,
                                      const std::vector<int64_t>& shape,
                                      const Locations& locations) {
  const auto found = locations.find(parameter);
  if (found == locations.end()) {
    return absl::InvalidArgumentError(
        absl::StrCat("parameter ", parameter, ": missing in the weights file"));
  }
  int64_t bytes = sizeof(float);
  for (const int64_t extent : shape) bytes *= extent;
  if (found->second.length != bytes) {
    return absl::InvalidArgumentError(absl::StrCat(
        "parameter ", parameter, ": expected ", bytes,
        " bytes in the weights file, found ", found->second.length));
  }
  return found->second;
}

absl::string_view DocOfInput(v1::GraphInput::Kind kind) {
  switch (kind) {
    case v1::GraphInput::KIND_NORMAL:
      return "Independent N(0, 1) numbers; zeros give the mean.";
    case v1::GraphInput::KIND_UNIFORM:
      return "Independent U[0, 1) numbers.";
    default:
      return "Data.";
  }
}

// The graph's inputs keep their names; results of nodes get a prefix that sets
// them apart from inputs and taps.
std::string ValueName(const v1::Graph& graph, const std::string& name) {
  for (const v1::GraphInput& input : graph.inputs()) {
    if (input.name() == name) return name;
  }
  return absl::StrCat("node:", name);
}

absl::Status AddNode(const v1::Graph& graph, const v1::Node& node,
                     const Shapes& shapes, const Widths& widths,
                     const Locations& locations, absl::string_view weights_file,
                     internal::OnnxGraph& onnx) {
  internal::OnnxOperation operation{.node = node};
  for (const std::string& input : node.inputs()) {
    operation.inputs.push_back(ValueName(graph, input));
  }
  for (const std::string& parameter : node.parameters()) {
    const std::vector<int64_t>& shape = shapes.at(parameter);
    SINEW_ASSIGN_OR_RETURN(const TensorLocation location,
                           Locate(parameter, shape, locations));
    const std::string name = absl::StrCat("parameter:", parameter);
    onnx.Weight(name, shape, weights_file, location);
    operation.parameters.push_back(name);
    operation.shapes.push_back(shape);
  }
  operation.in_width = widths.at(node.inputs(0));
  operation.out_width = widths.at(node.name());
  operation.output = ValueName(graph, node.name());
  internal::AddOnnxOperation(operation, onnx);
  return absl::OkStatus();
}

void AddTaps(const v1::Graph& graph, const Widths& widths,
             internal::OnnxGraph& onnx) {
  for (const v1::Tap& tap : graph.taps()) {
    onnx.Node("Identity", {ValueName(graph, tap.value())}, tap.name());
    onnx.Output(tap.name(), widths.at(tap.value()),
                tap.executed() ? "What the environment executes." : "");
  }
}

}  // namespace

absl::StatusOr<std::string> WriteOnnx(const v1::PolicyGraph& graph,
                                      absl::string_view graph_name,
                                      const Locations& locations,
                                      absl::string_view weights_file) {
  SINEW_RETURN_IF_ERROR(ValidateGraph(graph));
  SINEW_RETURN_IF_ERROR(CheckFileName(weights_file));
  SINEW_ASSIGN_OR_RETURN(const v1::Graph* one, FindGraph(graph, graph_name));
  SINEW_ASSIGN_OR_RETURN(const Widths widths, InferWidths(graph, graph_name));
  Shapes shapes;
  for (const v1::Parameter& parameter : graph.parameters()) {
    shapes[parameter.name()].assign(parameter.shape().begin(),
                                    parameter.shape().end());
  }
  onnx::ModelProto model;
  model.set_ir_version(kIrVersion);
  model.set_producer_name("sinew");
  onnx::OperatorSetIdProto* opset = model.add_opset_import();
  opset->set_domain("");
  opset->set_version(kOpset);
  model.mutable_graph()->set_name(one->name());
  internal::OnnxGraph onnx(*model.mutable_graph());
  for (const v1::GraphInput& input : one->inputs()) {
    onnx.Input(input.name(), input.width(), DocOfInput(input.kind()));
  }
  for (const v1::Node& node : one->nodes()) {
    SINEW_RETURN_IF_ERROR(
        AddNode(*one, node, shapes, widths, locations, weights_file, onnx));
  }
  AddTaps(*one, widths, onnx);
  return SerializeDeterministically(model);
}

}  // namespace sinew::policy
