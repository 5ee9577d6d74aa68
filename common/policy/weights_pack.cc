#include "common/policy/weights_pack.h"

#include <algorithm>
#include <utility>

#include "absl/strings/string_view.h"
#include "common/policy/linear_kernel.h"
#include "common/policy/validate.h"
#include "common/status_macros.h"

namespace sinew::policy {
namespace {

using internal::AlignedBuffer;
using internal::kPanel;
using internal::PackPanels;
using internal::RoundUp;
using internal::Step;

AlignedBuffer Copy(const HostTensor& tensor) {
  AlignedBuffer buffer(RoundUp(tensor.num_elements(), kPanel));
  const absl::Span<const float> values = tensor.float32();
  std::copy(values.begin(), values.end(), buffer.data());
  return buffer;
}

AlignedBuffer Panels(const HostTensor& weight) {
  const int64_t n = weight.shape[0];
  return PackPanels(weight.float32(), n, weight.num_elements() / n);
}

// weight[in, out, kernel] as panels of [out, in * kernel].
AlignedBuffer TransposedPanels(const HostTensor& weight) {
  const int64_t in = weight.shape[0];
  const int64_t out = weight.shape[1];
  const int64_t kernel = weight.shape[2];
  const absl::Span<const float> from = weight.float32();
  std::vector<float> turned(from.size());
  for (int64_t i = 0; i < in; ++i) {
    for (int64_t o = 0; o < out; ++o) {
      std::copy_n(from.begin() + (i * out + o) * kernel, kernel,
                  turned.begin() + (o * in + i) * kernel);
    }
  }
  return PackPanels(turned, out, in * kernel);
}

AlignedBuffer Pack(v1::Op op, size_t index, const HostTensor& tensor) {
  if (index > 0) return Copy(tensor);
  switch (op) {
    case v1::OP_LINEAR:
    case v1::OP_CONV1D:
    case v1::OP_ARGMIN:
      return Panels(tensor);
    case v1::OP_CONV1D_TRANSPOSE:
      return TransposedPanels(tensor);
    default:
      return Copy(tensor);
  }
}

}  // namespace

absl::StatusOr<std::shared_ptr<const WeightsPack>> PackWeights(
    const v1::PolicyGraph& graph, absl::string_view graph_name,
    const TensorMap& weights) {
  SINEW_RETURN_IF_ERROR(ValidateGraph(graph, weights));
  SINEW_ASSIGN_OR_RETURN(internal::Plan plan,
                         internal::MakePlan(graph, graph_name));
  std::vector<AlignedBuffer> parameters;
  for (const Step& step : plan.steps) {
    for (size_t i = 0; i < step.parameters.size(); ++i) {
      parameters.push_back(Pack(step.op, i, weights.at(step.parameters[i])));
    }
  }
  return std::make_shared<const WeightsPack>(std::move(plan),
                                             std::move(parameters));
}

}  // namespace sinew::policy
