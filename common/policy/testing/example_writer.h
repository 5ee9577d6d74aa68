#ifndef SINEW_COMMON_POLICY_TESTING_EXAMPLE_WRITER_H_
#define SINEW_COMMON_POLICY_TESTING_EXAMPLE_WRITER_H_

#include <cmath>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "common/policy/safetensors.h"
#include "common/policy/testing/examples.h"
#include "common/random/philox.h"
#include "proto/sinew/v1/graph.pb.h"

namespace sinew::policy::testing {

// Writes one graph by hand; every parameter gets random values.
//
// Thread-safety: one caller. Ownership: owns the example until Finish.
// Blocking: never. Errors: none; what it makes may be no valid graph.
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
    const int64_t fan_in = weight ? tensor.num_elements() / shape[0] : 1;
    for (float& value : tensor.mutable_float32()) {
      value /= std::sqrt(static_cast<float>(fan_in));
    }
    example_.weights[name] = std::move(tensor);
  }

  Example example_;
  uint64_t num_parameters_ = 0;
};

}  // namespace sinew::policy::testing

#endif  // SINEW_COMMON_POLICY_TESTING_EXAMPLE_WRITER_H_
