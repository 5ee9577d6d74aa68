#include "common/policy/testing/examples.h"

#include <cmath>
#include <utility>

#include "absl/strings/ascii.h"
#include "absl/strings/str_cat.h"
#include "common/check.h"
#include "common/policy/builder.h"
#include "common/policy/validate.h"
#include "common/random/philox.h"

namespace sinew::policy::testing {
namespace {

// Writes one graph by hand; every parameter gets random values.
class ExampleWriter {
 public:
  explicit ExampleWriter(std::string name) {
    example_.name = std::move(name);
    example_.graph_name = "example";
    example_.graph.set_format_version(1);
    example_.graph.add_graphs()->set_name("example");
  }

  ExampleWriter& Input(const std::string& name, int64_t width) {
    v1::GraphInput* input = graph().add_inputs();
    input->set_name(name);
    input->set_width(width);
    input->set_kind(v1::GraphInput::KIND_DATA);
    return *this;
  }

  v1::Node& Node(const std::string& name, v1::Op op,
                 const std::vector<std::string>& inputs,
                 const std::vector<std::vector<int64_t>>& shapes = {}) {
    v1::Node* node = graph().add_nodes();
    node->set_name(name);
    node->set_op(op);
    for (const std::string& input : inputs) node->add_inputs(input);
    for (const std::vector<int64_t>& shape : shapes) {
      AddParameter(absl::StrCat(name, "/", node->parameters_size()), shape,
                   *node);
    }
    return *node;
  }

  void Tap(const std::string& name, const std::string& value) {
    v1::Tap* tap = graph().add_taps();
    tap->set_name(name);
    tap->set_value(value);
  }

  Example Finish() { return std::move(example_); }

 private:
  v1::Graph& graph() { return *example_.graph.mutable_graphs(0); }

  // Normal with a standard deviation that keeps results near 1.
  void AddParameter(const std::string& name, const std::vector<int64_t>& shape,
                    v1::Node& node) {
    v1::Parameter* parameter = example_.graph.add_parameters();
    parameter->set_name(name);
    parameter->mutable_shape()->Add(shape.begin(), shape.end());
    node.add_parameters(name);
    HostTensor tensor = HostTensor::Zeros(shape);
    FillNormal({.seed = ++num_parameters_}, tensor.mutable_float32());
    const bool weight = shape.size() > 1 && node.op() != v1::OP_ARGMIN &&
                        node.op() != v1::OP_GATHER;
    const double fan_in = weight ? tensor.num_elements() / shape[0] : 1.0;
    for (float& value : tensor.mutable_float32()) {
      value /= static_cast<float>(std::sqrt(fan_in));
    }
    example_.weights[name] = std::move(tensor);
  }

  Example example_;
  uint64_t num_parameters_ = 0;
};

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

TrackingPolicyOptions PolicyOptions(v1::Network::Activation activation) {
  TrackingPolicyOptions options{.observation_width = 224, .action_width = 28};
  for (const int32_t width : {256, 100}) {
    options.network.add_policy_hidden(width);
    options.network.add_value_hidden(width);
  }
  options.network.set_activation(activation);
  options.network.set_last_layer_gain(0.5);
  options.network.set_observation_clip(2.5);
  options.network.set_initial_std(0.4);
  return options;
}

Example Tracking(v1::Network::Activation activation,
                 const std::string& graph_name) {
  const TrackingPolicyOptions options = PolicyOptions(activation);
  Example example;
  example.name =
      absl::StrCat(graph_name, "_",
                   absl::AsciiStrToLower(
                       v1::Network::Activation_Name(activation).substr(11)));
  example.graph = *BuildTrackingPolicy(options);
  example.graph_name = graph_name;
  example.weights = *InitialWeights(options, 11);
  HostTensor& mean = example.weights.at("normaliser/mean");
  FillNormal({.seed = 12}, mean.mutable_float32());
  HostTensor& inverse_std = example.weights.at("normaliser/inverse_std");
  FillUniform({.seed = 13}, inverse_std.mutable_float32());
  return example;
}

// Convolutional encoder, quantised and continuous latent, gated decoder.
Example Autoencoder() {
  ExampleWriter writer("autoencoder");
  writer.Input("window", 6 * 20).Input("state", 30).Input("epsilon", 8);
  v1::Node& conv =
      writer.Node("conv", v1::OP_CONV1D, {"window"}, {{10, 6, 5}, {10}});
  conv.set_channels(6);
  conv.set_stride(2);
  conv.set_padding(2);
  writer.Node("conv_elu", v1::OP_ELU, {"conv"});
  writer.Node("latent", v1::OP_LINEAR, {"conv_elu"}, {{16, 100}, {16}});
  writer.Node("latent_mean", v1::OP_SLICE, {"latent"}).set_end(8);
  v1::Node& log_std = writer.Node("log_std", v1::OP_SLICE, {"latent"});
  log_std.set_begin(8);
  log_std.set_end(16);
  writer.Node("std", v1::OP_EXP, {"log_std"});
  writer.Node("noise", v1::OP_MULTIPLY, {"std", "epsilon"});
  writer.Node("sample", v1::OP_ADD, {"latent_mean", "noise"});
  writer.Node("unit", v1::OP_L2_NORMALISE, {"sample"}).set_epsilon(1e-8);
  writer.Node("index", v1::OP_ARGMIN, {"unit"}, {{64, 8}});
  writer.Node("code", v1::OP_GATHER, {"index"}, {{64, 8}});
  writer.Node("rest", v1::OP_SUBTRACT, {"unit", "code"});
  writer.Node("context", v1::OP_CONCAT, {"state", "code", "rest"});
  writer.Node("norm", v1::OP_LAYER_NORM, {"context"}, {{46}, {46}})
      .set_epsilon(1e-5);
  writer.Node("gate_logits", v1::OP_LINEAR, {"norm"}, {{2, 46}, {2}});
  writer.Node("gate", v1::OP_SOFTMAX, {"gate_logits"});
  writer.Node("first", v1::OP_LINEAR, {"norm"}, {{40, 46}, {40}});
  writer.Node("second", v1::OP_LINEAR, {"norm"}, {{40, 46}, {40}});
  writer.Node("mixed", v1::OP_WEIGHTED_SUM, {"gate", "first", "second"});
  writer.Node("squashed", v1::OP_SIGMOID, {"mixed"});
  v1::Node& decoded = writer.Node("decoded", v1::OP_CONV1D_TRANSPOSE,
                                  {"squashed"}, {{4, 3, 4}, {3}});
  decoded.set_channels(4);
  decoded.set_stride(2);
  decoded.set_padding(1);
  writer.Tap("unit_latent", "unit");
  writer.Tap("index_of_code", "index");
  writer.Tap("window_out", "decoded");
  return writer.Finish();
}

}  // namespace

std::ostream& operator<<(std::ostream& out, const Example& example) {
  return out << example.name;
}

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

std::vector<Example> PolicyExamples() {
  std::vector<Example> examples;
  for (const auto activation :
       {v1::Network::ACTIVATION_SILU, v1::Network::ACTIVATION_RELU,
        v1::Network::ACTIVATION_ELU, v1::Network::ACTIVATION_TANH}) {
    examples.push_back(Tracking(activation, "policy"));
    examples.push_back(Tracking(activation, "critic"));
  }
  examples.push_back(Autoencoder());
  return examples;
}

std::vector<Example> AllExamples() {
  std::vector<Example> examples = OpExamples();
  for (Example& example : PolicyExamples()) {
    examples.push_back(std::move(example));
  }
  return examples;
}

std::map<std::string, std::vector<float>> ExampleInputs(const Example& example,
                                                        int batch,
                                                        uint64_t seed) {
  const v1::Graph& graph = **FindGraph(example.graph, example.graph_name);
  std::map<std::string, std::vector<float>> inputs;
  uint64_t index = 0;
  for (const v1::GraphInput& input : graph.inputs()) {
    std::vector<float>& values = inputs[input.name()];
    values.resize(batch * input.width());
    const RandomKey key = {.seed = seed, .environment = index++};
    if (input.kind() == v1::GraphInput::KIND_UNIFORM) {
      FillUniform(key, absl::MakeSpan(values));
      continue;
    }
    FillNormal(key, absl::MakeSpan(values));
    if (input.kind() == v1::GraphInput::KIND_NORMAL) continue;
    for (float& value : values) value *= 2.0f;
  }
  return inputs;
}

}  // namespace sinew::policy::testing
