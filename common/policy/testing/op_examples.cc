#include "absl/strings/ascii.h"
#include "common/policy/testing/example_writer.h"
#include "common/policy/testing/examples.h"

namespace sinew::policy::testing {
namespace {

constexpr int64_t kWidth = 37;

std::string OpName(v1::Op op) {
  return absl::AsciiStrToLower(v1::Op_Name(op).substr(3));
}

// x -> op -> y.
Example Single(const std::string& name, v1::Op op,
               const std::vector<std::vector<int64_t>>& shapes = {},
               const v1::Node& attributes = {}) {
  ExampleWriter writer(name);
  writer.Input("x", kWidth);
  writer.Node("y", op, {"x"}, shapes).MergeFrom(attributes);
  writer.Tap("result", "y");
  return writer.Finish();
}

Example Binary(v1::Op op) {
  ExampleWriter writer(OpName(op));
  writer.Input("a", kWidth).Input("b", kWidth);
  writer.Node("y", op, {"a", "b"});
  writer.Tap("result", "y");
  return writer.Finish();
}

v1::Node Attributes(double low, double high, int64_t begin, int64_t end,
                    double epsilon) {
  v1::Node node;
  node.set_low(low);
  node.set_high(high);
  node.set_begin(begin);
  node.set_end(end);
  node.set_epsilon(epsilon);
  return node;
}

Example Convolution(const std::string& name, v1::Op op, int64_t channels,
                    int64_t length, int64_t out, int64_t kernel, int64_t stride,
                    int64_t padding) {
  ExampleWriter writer(name);
  writer.Input("x", channels * length);
  const bool transpose = op == v1::OP_CONV1D_TRANSPOSE;
  v1::Node& node = writer.Node(
      "y", op, {"x"},
      {{transpose ? channels : out, transpose ? out : channels, kernel},
       {out}});
  node.set_channels(channels);
  node.set_stride(stride);
  node.set_padding(padding);
  writer.Tap("result", "y");
  return writer.Finish();
}

Example Concatenation() {
  ExampleWriter writer("concat");
  writer.Input("a", 5).Input("b", 11).Input("c", 1);
  writer.Node("y", v1::OP_CONCAT, {"b", "a", "c", "b"});
  writer.Tap("result", "y");
  writer.Tap("input_itself", "b");
  return writer.Finish();
}

// Distances to codes, then the code itself.
Example Quantiser() {
  ExampleWriter writer("argmin_gather");
  writer.Input("x", 6);
  writer.Node("index", v1::OP_ARGMIN, {"x"}, {{21, 6}});
  writer.Node("code", v1::OP_GATHER, {"index"}, {{21, 9}});
  writer.Tap("index_of_code", "index");
  writer.Tap("result", "code");
  return writer.Finish();
}

Example Experts() {
  ExampleWriter writer("weighted_sum");
  writer.Input("gate", 3).Input("a", kWidth).Input("b", kWidth);
  writer.Node("weights", v1::OP_SOFTMAX, {"gate"});
  writer.Node("y", v1::OP_WEIGHTED_SUM, {"weights", "a", "b", "a"});
  writer.Tap("result", "y");
  return writer.Finish();
}

}  // namespace

std::vector<Example> OpExamples() {
  const std::vector<int64_t> columns = {kWidth};
  std::vector<Example> examples = {
      Single("affine", v1::OP_AFFINE, {columns, columns}),
      Single("affine_without_shift", v1::OP_AFFINE, {columns}),
      Single("normalise", v1::OP_NORMALISE, {columns, columns}),
      Single("linear", v1::OP_LINEAR, {{29, kWidth}, {29}}),
      Single("linear_wide", v1::OP_LINEAR, {{130, kWidth}, {130}}),
      Single("layer_norm", v1::OP_LAYER_NORM, {columns, columns},
             Attributes(0, 0, 0, 0, 1e-5)),
      Single("clamp", v1::OP_CLAMP, {}, Attributes(-1.5, 0.75, 0, 0, 0)),
      Single("slice", v1::OP_SLICE, {}, Attributes(0, 0, 3, 14, 0)),
      Single("l2_normalise", v1::OP_L2_NORMALISE, {},
             Attributes(0, 0, 0, 0, 1e-6)),
      Single("l2_normalise_short", v1::OP_L2_NORMALISE, {},
             Attributes(0, 0, 0, 0, 50)),
      Convolution("conv1d", v1::OP_CONV1D, 3, 11, 5, 4, 2, 1),
      Convolution("conv1d_wide", v1::OP_CONV1D, 2, 9, 19, 3, 1, 2),
      Convolution("conv1d_transpose", v1::OP_CONV1D_TRANSPOSE, 3, 6, 5, 4, 2,
                  1),
      Convolution("conv1d_transpose_gaps", v1::OP_CONV1D_TRANSPOSE, 2, 5, 3, 2,
                  3, 0),
      Concatenation(),
      Quantiser(),
      Experts(),
  };
  for (const v1::Op op : {v1::OP_RELU, v1::OP_ELU, v1::OP_SILU, v1::OP_TANH,
                          v1::OP_SIGMOID, v1::OP_SOFTMAX, v1::OP_EXP}) {
    examples.push_back(Single(OpName(op), op));
  }
  for (const v1::Op op : {v1::OP_ADD, v1::OP_SUBTRACT, v1::OP_MULTIPLY}) {
    examples.push_back(Binary(op));
  }
  return examples;
}

}  // namespace sinew::policy::testing
