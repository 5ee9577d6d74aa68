#ifndef SINEW_COMMON_POLICY_ONNX_ONNX_OPS_H_
#define SINEW_COMMON_POLICY_ONNX_ONNX_OPS_H_

#include <cstdint>
#include <string>
#include <vector>

#include "common/policy/onnx/onnx_graph.h"
#include "proto/sinew/v1/graph.pb.h"

namespace sinew::policy::internal {

// One node of a valid graph, its names replaced by those of the ONNX model.
struct OnnxOperation {
  const v1::Node& node;
  std::vector<std::string> inputs = {};
  std::vector<std::string> parameters = {};
  // Widths of the first input and of the result; extents of the parameters.
  int64_t in_width = 0;
  int64_t out_width = 0;
  std::vector<std::vector<int64_t>> shapes = {};
  // Name of the result; names that begin with it and a colon are free.
  std::string output = {};
};

// Adds the ONNX operations that do what ops.h says of node.op().
void AddOnnxOperation(const OnnxOperation& operation, OnnxGraph& graph);

}  // namespace sinew::policy::internal

#endif  // SINEW_COMMON_POLICY_ONNX_ONNX_OPS_H_
