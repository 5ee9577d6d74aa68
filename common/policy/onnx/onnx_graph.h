#ifndef SINEW_COMMON_POLICY_ONNX_ONNX_GRAPH_H_
#define SINEW_COMMON_POLICY_ONNX_ONNX_GRAPH_H_

#include <cstdint>
#include <set>
#include <string>
#include <vector>

#include "absl/strings/string_view.h"
#include "absl/types/span.h"
#include "common/policy/safetensors.h"
#include "onnx/onnx_pb.h"

namespace sinew::policy::internal {

// Adds nodes, constants and weights to an onnx::GraphProto. Names are the
// caller's, who keeps them unique.
//
// Thread-safety: one caller. Ownership: borrows the graph. Errors: none.
class OnnxGraph {
 public:
  explicit OnnxGraph(onnx::GraphProto& graph) : graph_(graph) {}

  // A node with one output, which is also its name; attributes may be added to
  // the result, which is valid until the next node.
  onnx::NodeProto& Node(absl::string_view op,
                        absl::Span<const std::string> inputs,
                        const std::string& output);

  // Constants within the model; they return their name.
  std::string Float(const std::string& name, float value);
  std::string Int64s(const std::string& name, absl::Span<const int64_t> values);

  // A float32 weight in another file; at most once for each name.
  void Weight(const std::string& name, absl::Span<const int64_t> shape,
              absl::string_view file, const TensorLocation& location);

  // The model's own inputs and outputs, float32 ["batch", width].
  void Input(const std::string& name, int64_t width, absl::string_view doc);
  void Output(const std::string& name, int64_t width, absl::string_view doc);

 private:
  onnx::GraphProto& graph_;
  std::set<std::string> weights_;
};

// Attributes of a node.
void SetInt(onnx::NodeProto& node, absl::string_view name, int64_t value);
void SetInts(onnx::NodeProto& node, absl::string_view name,
             absl::Span<const int64_t> values);
void SetFloat(onnx::NodeProto& node, absl::string_view name, float value);

}  // namespace sinew::policy::internal

#endif  // SINEW_COMMON_POLICY_ONNX_ONNX_GRAPH_H_
