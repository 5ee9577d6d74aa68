#ifndef SINEW_COMMON_POLICY_VALIDATE_H_
#define SINEW_COMMON_POLICY_VALIDATE_H_

#include <cstdint>
#include <map>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "common/policy/safetensors.h"
#include "proto/sinew/v1/graph.pb.h"

namespace sinew::policy {

// Pure functions: thread-safe, never blocking.

// Checks everything that graph.proto and ops.h demand, of every graph: format
// version, names (letters, digits, "_", ".", "-", "/"; unique; taps also
// differ from inputs), order of nodes, widths, parameter shapes, attributes,
// taps (at most one executed) and that `weights` holds every parameter as
// float32 of its shape (further tensors are ignored) with standard deviations
// > 0. INVALID_ARGUMENT names graph, node or tap, what was expected and found.
absl::Status ValidateGraph(const v1::PolicyGraph& graph,
                           const TensorMap& weights);

// The same without weights.
absl::Status ValidateGraph(const v1::PolicyGraph& graph);

// Widths of every input and node of a graph, by name. NOT_FOUND: no graph of
// that name. INVALID_ARGUMENT as above.
absl::StatusOr<std::map<std::string, int64_t>> InferWidths(
    const v1::PolicyGraph& graph, absl::string_view graph_name);

// The graph of that name. NOT_FOUND lists the names that there are.
absl::StatusOr<const v1::Graph*> FindGraph(const v1::PolicyGraph& graph,
                                           absl::string_view graph_name);

}  // namespace sinew::policy

#endif  // SINEW_COMMON_POLICY_VALIDATE_H_
