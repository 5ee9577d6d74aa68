#ifndef SINEW_LEARNER_TORCH_TRAINED_NETWORK_H_
#define SINEW_LEARNER_TORCH_TRAINED_NETWORK_H_

#include <ATen/core/Tensor.h>
#include <c10/core/Device.h>

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/types/span.h"
#include "common/policy/safetensors.h"
#include "learner/torch/graph_module.h"
#include "learner/torch/parameter_buffer.h"
#include "proto/sinew/v1/graph.pb.h"

namespace sinew::learner {

// One graph's trained parameters with their gradients and Adam's moments, and
// its batch of frozen-frontier values (see GraphModule::FrozenFrontier).
// Outputs are [rows, width] each, in the order of Options::outputs.
//
// Thread-safety: Load and Forward on any thread for disjoint rows; Parameters
//   and Gradient by shard, one thread each; the rest alone. Ownership: owns
//   trained tensors; shares `frozen`'s memory. Blocking: computes. Errors:
//   Create INVALID_ARGUMENT; the rest throws c10::Error (use CatchTorch).
class TrainedNetwork {
 public:
  struct Options {
    std::string graph_name;
    std::vector<std::string> inputs;   // all that `outputs` depend on
    std::vector<std::string> outputs;  // nodes
    // Trained parameters that the loss reads beside the graph.
    std::vector<int> extra_parameters = {};
    Precision precision = Precision::kFloat32;
    int shards = 1;
  };

  // `frozen` has one tensor per parameter of the graph; those that this
  // network trains are ignored.
  static absl::StatusOr<std::unique_ptr<TrainedNetwork>> Create(
      const v1::PolicyGraph& graph, const Options& options,
      absl::Span<const at::Tensor> frozen, const at::Device& device);

  // Per row: from the input to the frontier, from there on, and back to there.
  double load_flops() const { return prefix_.forward_flops; }
  double forward_flops() const { return plan_.forward_flops; }
  double backward_flops() const { return plan_.backward_flops; }
  ParameterBuffer& weights() { return weights_; }
  const ParameterBuffer& weights() const { return weights_; }

  void Reserve(int64_t rows);
  // Brings raw inputs, [n, width] each, to the frontier, into rows from
  // `first_row`.
  void Load(int64_t first_row, absl::Span<const at::Tensor> inputs);

  // Outputs of consecutive rows, without gradients.
  std::vector<at::Tensor> Forward(int64_t first_row, int64_t rows) const;
  // Outputs of rows by number, differentiable in the shard's parameters if
  // gradients are on.
  std::vector<at::Tensor> Forward(int shard, const at::Tensor& rows) const;
  // The same of raw inputs, [n, width] each, which are not kept: no Reserve and
  // no Load, any shards at a time.
  std::vector<at::Tensor> ForwardInputs(
      int shard, absl::Span<const at::Tensor> inputs) const;
  // All parameters of the graph as the shard sees them.
  absl::Span<const at::Tensor> Parameters(int shard) const {
    return shards_[shard].parameters;
  }
  // d loss / d weights into the shard's gradient.
  void Gradient(int shard, const at::Tensor& loss);

  // Sums the shards in order (into the first); returns the norm.
  double SumGradients();
  // That sum, until the next Gradient of shard 0.
  const ParameterBuffer& gradient() const { return shards_[0].gradient; }
  void Step(double learning_rate, double gradient_scale);

  absl::Status LoadMoments(const TensorMap& tensors, int64_t steps);
  void SaveMoments(TensorMap& tensors) const;
  int64_t steps() const { return steps_; }

 private:
  struct Shard {
    std::vector<at::Tensor> leaves;      // trained, in the order of weights_
    std::vector<at::Tensor> parameters;  // of the whole graph
    ParameterBuffer gradient;
  };

  TrainedNetwork(const v1::PolicyGraph& graph,
                 std::unique_ptr<const GraphModule> module,
                 const std::vector<int>& trained, const at::Device& device);

  const std::unique_ptr<const GraphModule> module_;
  GraphPlan prefix_;  // inputs -> frontier
  GraphPlan plan_;    // frontier -> outputs
  ParameterBuffer weights_, first_moment_, second_moment_;
  std::vector<at::Tensor> frozen_;  // of the whole graph, for prefix_
  std::vector<Shard> shards_;
  std::vector<at::Tensor> frontier_;  // each [rows, width]
  int64_t steps_ = 0;
};

}  // namespace sinew::learner

#endif  // SINEW_LEARNER_TORCH_TRAINED_NETWORK_H_
