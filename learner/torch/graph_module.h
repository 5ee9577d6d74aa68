#ifndef SINEW_LEARNER_TORCH_GRAPH_MODULE_H_
#define SINEW_LEARNER_TORCH_GRAPH_MODULE_H_

#include <ATen/core/Tensor.h>

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "absl/types/span.h"
#include "proto/sinew/v1/graph.pb.h"

namespace sinew::learner {

// Type of matrix products and convolutions. Parameters and results are float32
// either way; in bfloat16 an activation between two products stays bfloat16.
enum class Precision { kFloat32, kBfloat16 };

// A part of a graph: from given values to wanted ones. Made by MakePlan.
struct GraphPlan {
  std::vector<int> given;   // values that the caller hands in
  std::vector<int> nodes;   // to compute, in order
  std::vector<int> wanted;  // values that come back
  // Floating-point operations per row, a multiply-add counting two: forward,
  // and backward to the parameters that are not frozen. Products only.
  double forward_flops = 0;
  double backward_flops = 0;
};

// One graph of a PolicyGraph, run by libtorch: the back end that trains. Holds
// structure only; parameters are arguments, so that several threads can
// differentiate the same graph at once, each with leaves of its own. Semantics
// of the operations: graph.proto and common/policy/ops.h.
//
// Values are numbered: inputs first, then nodes. Parameters are numbered as in
// PolicyGraph.parameters, whether this graph reads them or not.
//
// Thread-safety: immutable; Run from any thread. Ownership: copies the graph.
// Blocking: Run computes on the calling thread. Errors: Create and MakePlan
// return INVALID_ARGUMENT or NOT_FOUND; Run throws c10::Error for tensors that
// do not fit (call it under CatchTorch).
class GraphModule {
 public:
  // Validates `graph` in full.
  static absl::StatusOr<std::unique_ptr<const GraphModule>> Create(
      const v1::PolicyGraph& graph, absl::string_view graph_name,
      Precision precision);

  const v1::Graph& graph() const { return graph_; }

  // The nodes that lead from `given` to `wanted` (names of inputs or nodes).
  // INVALID_ARGUMENT if an input is needed that is not given.
  absl::StatusOr<GraphPlan> MakePlan(
      absl::Span<const std::string> given,
      absl::Span<const std::string> wanted) const;

  // Values that no trained parameter influences and that `wanted` is computed
  // from by trained ones: compute them once per batch, then plan from them.
  // A wanted value that is not trained at all is its own frontier.
  std::vector<std::string> FrozenFrontier(
      absl::Span<const std::string> wanted) const;

  // Numbers of the parameters that a plan reads and that are not frozen.
  std::vector<int> TrainedParameters(const GraphPlan& plan) const;

  // Evaluates a plan. given[i] is [batch, width] float32; `parameters` has one
  // tensor per parameter of the PolicyGraph (those not read may be undefined).
  // Returns one [batch, width] float32 tensor per wanted value.
  std::vector<at::Tensor> Run(const GraphPlan& plan,
                              absl::Span<const at::Tensor> given,
                              absl::Span<const at::Tensor> parameters) const;

 private:
  struct NodeInfo {
    std::vector<int> inputs;
    std::vector<int> parameters;
    bool trained = false;        // a trained parameter influences the value
    bool input_trained = false;  // ... the first input
    bool parameter_trained = false;
    int64_t multiply_adds = 0;  // per row
  };

  GraphModule(v1::Graph graph, Precision precision);
  absl::Status Resolve(const v1::PolicyGraph& all);
  int ValueIndex(absl::string_view name) const;  // -1: none
  const std::string& ValueName(int value) const;
  const NodeInfo* NodeOf(int value) const;  // null: an input
  bool Trained(int value) const;
  at::Tensor Evaluate(int node, absl::Span<const at::Tensor> values,
                      absl::Span<const at::Tensor> parameters) const;

  const v1::Graph graph_;
  const Precision precision_;
  std::vector<NodeInfo> nodes_;
  std::vector<bool> frozen_;  // by parameter
};

}  // namespace sinew::learner

#endif  // SINEW_LEARNER_TORCH_GRAPH_MODULE_H_
