#ifndef SINEW_COMMON_POLICY_GRAPH_WRITER_H_
#define SINEW_COMMON_POLICY_GRAPH_WRITER_H_

#include <array>
#include <cstdint>
#include <string>

#include "absl/types/span.h"
#include "proto/sinew/v1/graph.pb.h"

namespace sinew::policy::internal {

// Adds nodes to one graph, and the parameters that they name.
//
// Thread-safety: one caller. Ownership: borrows both messages. Blocking: never.
// Errors: none; ValidateGraph says whether the result is a graph.
class GraphWriter {
 public:
  GraphWriter(v1::PolicyGraph& all, v1::Graph& graph)
      : all_(all), graph_(graph) {}

  void Input(const std::string& name, int64_t width,
             v1::GraphInput::Kind kind) {
    v1::GraphInput* input = graph_.add_inputs();
    input->set_name(name);
    input->set_width(width);
    input->set_kind(kind);
  }

  v1::Node& Node(const std::string& name, v1::Op op,
                 absl::Span<const std::string> inputs,
                 absl::Span<const std::string> parameters = {}) {
    v1::Node* node = graph_.add_nodes();
    node->set_name(name);
    node->set_op(op);
    for (const std::string& input : inputs) node->add_inputs(input);
    for (const std::string& one : parameters) node->add_parameters(one);
    return *node;
  }

  // Shared by name: a parameter that exists already is left alone.
  void Parameter(const std::string& name, absl::Span<const int64_t> shape,
                 bool frozen) {
    for (const v1::Parameter& known : all_.parameters()) {
      if (known.name() == name) return;
    }
    v1::Parameter* parameter = all_.add_parameters();
    parameter->set_name(name);
    parameter->mutable_shape()->Add(shape.begin(), shape.end());
    parameter->set_frozen(frozen);
  }

  // A layer with parameters PREFIX/weight of `shape` [out, in], PREFIX/bias.
  void Linear(const std::string& name, const std::string& input,
              const std::string& prefix, const std::array<int64_t, 2>& shape,
              bool frozen) {
    const std::string weight = prefix + "/weight";
    const std::string bias = prefix + "/bias";
    Parameter(weight, shape, frozen);
    Parameter(bias, {shape[0]}, frozen);
    Node(name, v1::OP_LINEAR, {input}, {weight, bias});
  }

  v1::Tap& Tap(const std::string& name, const std::string& value) {
    v1::Tap* tap = graph_.add_taps();
    tap->set_name(name);
    tap->set_value(value);
    return *tap;
  }

 private:
  v1::PolicyGraph& all_;
  v1::Graph& graph_;
};

}  // namespace sinew::policy::internal

#endif  // SINEW_COMMON_POLICY_GRAPH_WRITER_H_
