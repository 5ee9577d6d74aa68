#ifndef SINEW_COMMON_POLICY_ONNX_ONNX_WRITER_H_
#define SINEW_COMMON_POLICY_ONNX_ONNX_WRITER_H_

#include <map>
#include <string>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "common/policy/safetensors.h"
#include "proto/sinew/v1/graph.pb.h"

namespace sinew::policy {

// One graph as a serialised ONNX model (IR version 8, opset 17), equal bytes
// for equal arguments. Its inputs and outputs have the names of the graph's
// inputs (noise included) and taps, float32 ["batch", width]. Everything else
// has a name with a colon, which graphs do not have. Weights are external data
// within `weights_file`, a safetensors file beside the model in which
// `locations` (LocateSafetensors) says where each parameter lies.
//
// Two things differ from the executor: an index outside a codebook is an
// error of the ONNX runtime, not NaN, and its results are not bit-equal.
//
// INVALID_ARGUMENT: the graph is not valid, `weights_file` is no plain file
// name, or a parameter's location is missing or of another size. NOT_FOUND: no
// graph of that name.
//
// Thread-safety: pure function. Blocking: never.
absl::StatusOr<std::string> WriteOnnx(
    const v1::PolicyGraph& graph, absl::string_view graph_name,
    const std::map<std::string, TensorLocation>& locations,
    absl::string_view weights_file);

}  // namespace sinew::policy

#endif  // SINEW_COMMON_POLICY_ONNX_ONNX_WRITER_H_
