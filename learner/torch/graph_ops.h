#ifndef SINEW_LEARNER_TORCH_GRAPH_OPS_H_
#define SINEW_LEARNER_TORCH_GRAPH_OPS_H_

#include <ATen/core/Tensor.h>

#include "absl/types/span.h"
#include "learner/torch/graph_module.h"
#include "proto/sinew/v1/graph.pb.h"

namespace sinew::learner {

// One operation as ops.h defines it, differentiable where it is. Inputs are
// [batch, width]. Pure; throws c10::Error.
at::Tensor EvaluateOp(const v1::Node& node, Precision precision,
                      absl::Span<const at::Tensor> inputs,
                      absl::Span<const at::Tensor> parameters);

}  // namespace sinew::learner

#endif  // SINEW_LEARNER_TORCH_GRAPH_OPS_H_
