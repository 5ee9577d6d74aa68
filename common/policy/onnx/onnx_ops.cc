#include "common/policy/onnx/onnx_ops.h"

#include "absl/strings/str_cat.h"
#include "common/check.h"

namespace sinew::policy::internal {
namespace {

void Affine(const OnnxOperation& o, OnnxGraph& graph) {
  if (o.parameters.size() == 1) {
    graph.Node("Mul", {o.inputs[0], o.parameters[0]}, o.output);
    return;
  }
  graph.Node("Mul", {o.inputs[0], o.parameters[0]}, o.output + ":scaled");
  graph.Node("Add", {o.output + ":scaled", o.parameters[1]}, o.output);
}

void Normalise(const OnnxOperation& o, OnnxGraph& graph) {
  graph.Node("Sub", {o.inputs[0], o.parameters[0]}, o.output + ":centred");
  graph.Node("Mul", {o.output + ":centred", o.parameters[1]}, o.output);
}

void Linear(const OnnxOperation& o, OnnxGraph& graph) {
  onnx::NodeProto& gemm = graph.Node(
      "Gemm", {o.inputs[0], o.parameters[0], o.parameters[1]}, o.output);
  SetInt(gemm, "transB", 1);
}

// [batch, width] -> [batch, channels, length] -> convolution -> [batch, width].
void Convolution(const OnnxOperation& o, OnnxGraph& graph) {
  const bool transpose = o.node.op() == v1::OP_CONV1D_TRANSPOSE;
  const int64_t channels = o.node.channels();
  const std::string in_shape = graph.Int64s(
      o.output + ":in_shape", {-1, channels, o.in_width / channels});
  graph.Node("Reshape", {o.inputs[0], in_shape}, o.output + ":in");
  onnx::NodeProto& convolution = graph.Node(
      transpose ? "ConvTranspose" : "Conv",
      {o.output + ":in", o.parameters[0], o.parameters[1]}, o.output + ":out");
  SetInts(convolution, "kernel_shape", {o.shapes[0][2]});
  SetInts(convolution, "pads", {o.node.padding(), o.node.padding()});
  SetInts(convolution, "strides", {o.node.stride()});
  const std::string out_shape =
      graph.Int64s(o.output + ":out_shape", {-1, o.out_width});
  graph.Node("Reshape", {o.output + ":out", out_shape}, o.output);
}

void LayerNorm(const OnnxOperation& o, OnnxGraph& graph) {
  onnx::NodeProto& norm =
      graph.Node("LayerNormalization",
                 {o.inputs[0], o.parameters[0], o.parameters[1]}, o.output);
  SetInt(norm, "axis", -1);
  SetFloat(norm, "epsilon", static_cast<float>(o.node.epsilon()));
}

void Silu(const OnnxOperation& o, OnnxGraph& graph) {
  graph.Node("Sigmoid", {o.inputs[0]}, o.output + ":gate");
  graph.Node("Mul", {o.inputs[0], o.output + ":gate"}, o.output);
}

void Slice(const OnnxOperation& o, OnnxGraph& graph) {
  const std::string begin = graph.Int64s(o.output + ":begin", {o.node.begin()});
  const std::string end = graph.Int64s(o.output + ":end", {o.node.end()});
  const std::string axis = graph.Int64s(o.output + ":axis", {1});
  graph.Node("Slice", {o.inputs[0], begin, end, axis}, o.output);
}

void Clamp(const OnnxOperation& o, OnnxGraph& graph) {
  const std::string low =
      graph.Float(o.output + ":low", static_cast<float>(o.node.low()));
  const std::string high =
      graph.Float(o.output + ":high", static_cast<float>(o.node.high()));
  graph.Node("Clip", {o.inputs[0], low, high}, o.output);
}

void L2Normalise(const OnnxOperation& o, OnnxGraph& graph) {
  onnx::NodeProto& norm =
      graph.Node("ReduceL2", {o.inputs[0]}, o.output + ":norm");
  SetInts(norm, "axes", {1});
  SetInt(norm, "keepdims", 1);
  const std::string least =
      graph.Float(o.output + ":least", static_cast<float>(o.node.epsilon()));
  graph.Node("Max", {o.output + ":norm", least}, o.output + ":divisor");
  graph.Node("Div", {o.inputs[0], o.output + ":divisor"}, o.output);
}

// [batch, 1, width] - [n, width], squared and summed: [batch, n].
void Argmin(const OnnxOperation& o, OnnxGraph& graph) {
  const std::string shape =
      graph.Int64s(o.output + ":shape", {-1, 1, o.in_width});
  graph.Node("Reshape", {o.inputs[0], shape}, o.output + ":point");
  graph.Node("Sub", {o.output + ":point", o.parameters[0]},
             o.output + ":difference");
  onnx::NodeProto& distance = graph.Node(
      "ReduceSumSquare", {o.output + ":difference"}, o.output + ":distance");
  SetInts(distance, "axes", {2});
  SetInt(distance, "keepdims", 0);
  onnx::NodeProto& nearest =
      graph.Node("ArgMin", {o.output + ":distance"}, o.output + ":index");
  SetInt(nearest, "axis", 1);
  SetInt(nearest, "keepdims", 1);
  SetInt(nearest, "select_last_index", 0);
  onnx::NodeProto& cast = graph.Node("Cast", {o.output + ":index"}, o.output);
  SetInt(cast, "to", onnx::TensorProto::FLOAT);
}

void Gather(const OnnxOperation& o, OnnxGraph& graph) {
  onnx::NodeProto& cast =
      graph.Node("Cast", {o.inputs[0]}, o.output + ":index");
  SetInt(cast, "to", onnx::TensorProto::INT64);
  const std::string shape = graph.Int64s(o.output + ":shape", {-1});
  graph.Node("Reshape", {o.output + ":index", shape}, o.output + ":flat");
  onnx::NodeProto& gather =
      graph.Node("Gather", {o.parameters[0], o.output + ":flat"}, o.output);
  SetInt(gather, "axis", 0);
}

void WeightedSum(const OnnxOperation& o, OnnxGraph& graph) {
  const std::string axis = graph.Int64s(o.output + ":axis", {1});
  std::vector<std::string> terms;
  for (size_t i = 0; i + 1 < o.inputs.size(); ++i) {
    const std::string prefix = absl::StrCat(o.output, ":", i);
    const int64_t column = static_cast<int64_t>(i);
    const std::string begin = graph.Int64s(prefix + ":begin", {column});
    const std::string end = graph.Int64s(prefix + ":end", {column + 1});
    graph.Node("Slice", {o.inputs[0], begin, end, axis}, prefix + ":weight");
    graph.Node("Mul", {prefix + ":weight", o.inputs[i + 1]}, prefix + ":term");
    terms.push_back(prefix + ":term");
  }
  graph.Node("Sum", terms, o.output);
}

// The ONNX operation of the same meaning, or null.
const char* DirectName(v1::Op op) {
  switch (op) {
    case v1::OP_RELU:
      return "Relu";
    case v1::OP_ELU:
      return "Elu";  // alpha is 1 there too
    case v1::OP_TANH:
      return "Tanh";
    case v1::OP_SIGMOID:
      return "Sigmoid";
    case v1::OP_EXP:
      return "Exp";
    case v1::OP_ADD:
      return "Add";
    case v1::OP_SUBTRACT:
      return "Sub";
    case v1::OP_MULTIPLY:
      return "Mul";
    default:
      return nullptr;
  }
}

}  // namespace

void AddOnnxOperation(const OnnxOperation& o, OnnxGraph& graph) {
  if (const char* name = DirectName(o.node.op()); name != nullptr) {
    graph.Node(name, o.inputs, o.output);
    return;
  }
  switch (o.node.op()) {
    case v1::OP_AFFINE:
      return Affine(o, graph);
    case v1::OP_NORMALISE:
      return Normalise(o, graph);
    case v1::OP_LINEAR:
      return Linear(o, graph);
    case v1::OP_CONV1D:
    case v1::OP_CONV1D_TRANSPOSE:
      return Convolution(o, graph);
    case v1::OP_LAYER_NORM:
      return LayerNorm(o, graph);
    case v1::OP_SILU:
      return Silu(o, graph);
    case v1::OP_SOFTMAX:
      return SetInt(graph.Node("Softmax", o.inputs, o.output), "axis", 1);
    case v1::OP_CONCAT:
      return SetInt(graph.Node("Concat", o.inputs, o.output), "axis", 1);
    case v1::OP_SLICE:
      return Slice(o, graph);
    case v1::OP_CLAMP:
      return Clamp(o, graph);
    case v1::OP_L2_NORMALISE:
      return L2Normalise(o, graph);
    case v1::OP_ARGMIN:
      return Argmin(o, graph);
    case v1::OP_GATHER:
      return Gather(o, graph);
    case v1::OP_WEIGHTED_SUM:
      return WeightedSum(o, graph);
    default:
      SINEW_CHECK(false) << v1::Op_Name(o.node.op());
  }
}

}  // namespace sinew::policy::internal
