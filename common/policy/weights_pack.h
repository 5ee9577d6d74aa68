#ifndef SINEW_COMMON_POLICY_WEIGHTS_PACK_H_
#define SINEW_COMMON_POLICY_WEIGHTS_PACK_H_

#include <memory>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "common/policy/aligned_buffer.h"
#include "common/policy/plan.h"
#include "common/policy/safetensors.h"
#include "proto/sinew/v1/graph.pb.h"

namespace sinew::policy {

// One graph with its weights, laid out for an Executor.
//
// Thread-safety: immutable; shared by the executors of any number of threads.
// Ownership: holds copies of everything. Blocking: never.
class WeightsPack {
 public:
  WeightsPack(internal::Plan plan,
              std::vector<internal::AlignedBuffer> parameters)
      : plan_(std::move(plan)), parameters_(std::move(parameters)) {}

  // For executors only.
  const internal::Plan& plan() const { return plan_; }
  // Packed parameters of a step, in the order of the node's parameters.
  const internal::AlignedBuffer* parameters(const internal::Step& step) const {
    return parameters_.data() + step.first_parameter;
  }

 private:
  const internal::Plan plan_;
  const std::vector<internal::AlignedBuffer> parameters_;
};

// Validates graph and weights (ValidateGraph) and lays out the named graph.
absl::StatusOr<std::shared_ptr<const WeightsPack>> PackWeights(
    const v1::PolicyGraph& graph, absl::string_view graph_name,
    const TensorMap& weights);

}  // namespace sinew::policy

#endif  // SINEW_COMMON_POLICY_WEIGHTS_PACK_H_
