#include "learner/torch/graph_ops.h"

#include <ATen/ATen.h>

#include <algorithm>
#include <limits>
#include <vector>

#include "common/check.h"

namespace sinew::learner {
namespace {

using at::Tensor;

// Elements of the largest intermediate of ARGMIN: 16 MiB.
constexpr int64_t kArgminElements = int64_t{1} << 22;

Tensor ProductType(const Tensor& x, Precision precision) {
  return precision == Precision::kBfloat16 ? x.to(at::kBFloat16)
                                           : x.to(at::kFloat);
}

Tensor Linear(Precision precision, const Tensor& x, const Tensor& weight,
              const Tensor& bias) {
  return at::linear(ProductType(x, precision), ProductType(weight, precision),
                    ProductType(bias, precision));
}

Tensor Convolution(const v1::Node& node, Precision precision, const Tensor& x,
                   const Tensor& weight, const Tensor& bias) {
  const Tensor image =
      ProductType(x, precision).reshape({x.size(0), node.channels(), -1});
  const Tensor w = ProductType(weight, precision);
  const Tensor b = ProductType(bias, precision);
  const Tensor y =
      node.op() == v1::OP_CONV1D
          ? at::conv1d(image, w, b, node.stride(), node.padding())
          : at::conv_transpose1d(image, w, b, node.stride(), node.padding());
  return y.flatten(1);
}

Tensor L2Normalise(const Tensor& x, double epsilon) {
  return x / x.norm(2, {1}, /*keepdim=*/true).clamp_min(epsilon);
}

// Rows are taken in pieces, so that [rows, n, width] stays small.
Tensor Argmin(const Tensor& x, const Tensor& codebook) {
  const int64_t rows = std::max<int64_t>(
      1, kArgminElements / std::max<int64_t>(1, codebook.numel()));
  std::vector<Tensor> pieces;
  for (const Tensor& piece : x.detach().split(rows, 0)) {
    const Tensor distance =
        (piece.unsqueeze(1) - codebook.detach()).square().sum(-1);
    const Tensor index = distance.argmin(1, /*keepdim=*/true).to(at::kFloat);
    pieces.push_back(
        index.masked_fill(piece.isnan().any(1, /*keepdim=*/true),
                          std::numeric_limits<double>::quiet_NaN()));
  }
  if (pieces.empty()) return at::empty({0, 1}, x.options());
  return at::cat(pieces, 0);
}

Tensor Gather(const Tensor& x, const Tensor& codebook) {
  const Tensor index = x.detach().trunc();
  // False for NaN as well.
  const Tensor inside = (index >= 0).logical_and(index < codebook.size(0));
  const Tensor row =
      at::where(inside, index, at::zeros_like(index)).to(at::kLong).squeeze(1);
  return codebook.index_select(0, row).masked_fill(
      inside.logical_not(), std::numeric_limits<double>::quiet_NaN());
}

Tensor WeightedSum(absl::Span<const Tensor> inputs) {
  Tensor sum = inputs[0].narrow(1, 0, 1) * inputs[1];
  for (size_t i = 2; i < inputs.size(); ++i) {
    sum = sum + inputs[0].narrow(1, i - 1, 1) * inputs[i];
  }
  return sum;
}

Tensor Affine(const Tensor& x, absl::Span<const Tensor> parameters) {
  const Tensor scaled = x * parameters[0];
  return parameters.size() > 1 ? scaled + parameters[1] : scaled;
}

// Operations that may run on a bfloat16 activation; undefined for others.
Tensor Activation(v1::Op op, const Tensor& x) {
  switch (op) {
    case v1::OP_RELU:
      return at::relu(x);
    case v1::OP_ELU:
      return at::elu(x);
    case v1::OP_SILU:
      return at::silu(x);
    case v1::OP_TANH:
      return at::tanh(x);
    case v1::OP_SIGMOID:
      return at::sigmoid(x);
    default:
      return Tensor();
  }
}

Tensor Float32Op(const v1::Node& node, absl::Span<const Tensor> inputs,
                 absl::Span<const Tensor> parameters) {
  const Tensor& x = inputs[0];
  switch (node.op()) {
    case v1::OP_AFFINE:
      return Affine(x, parameters);
    case v1::OP_NORMALISE:
      return (x - parameters[0]) * parameters[1];
    case v1::OP_LAYER_NORM:
      return at::layer_norm(x, {x.size(1)}, parameters[0], parameters[1],
                            node.epsilon());
    case v1::OP_SOFTMAX:
      return at::softmax(x, 1);
    case v1::OP_CONCAT:
      return at::cat(std::vector<Tensor>(inputs.begin(), inputs.end()), 1);
    case v1::OP_SLICE:
      return x.slice(1, node.begin(), node.end());
    case v1::OP_ADD:
      return x + inputs[1];
    case v1::OP_SUBTRACT:
      return x - inputs[1];
    case v1::OP_MULTIPLY:
      return x * inputs[1];
    case v1::OP_CLAMP:
      return at::clamp(x, node.low(), node.high());
    case v1::OP_EXP:
      return at::exp(x);
    case v1::OP_L2_NORMALISE:
      return L2Normalise(x, node.epsilon());
    case v1::OP_ARGMIN:
      return Argmin(x, parameters[0]);
    case v1::OP_GATHER:
      return Gather(x, parameters[0]);
    case v1::OP_WEIGHTED_SUM:
      return WeightedSum(inputs);
    default:
      SINEW_CHECK(false) << "operation " << node.op() << " passed validation";
      return Tensor();
  }
}

}  // namespace

Tensor EvaluateOp(const v1::Node& node, Precision precision,
                  absl::Span<const Tensor> inputs,
                  absl::Span<const Tensor> parameters) {
  if (node.op() == v1::OP_LINEAR) {
    return Linear(precision, inputs[0], parameters[0], parameters[1]);
  }
  if (node.op() == v1::OP_CONV1D || node.op() == v1::OP_CONV1D_TRANSPOSE) {
    return Convolution(node, precision, inputs[0], parameters[0],
                       parameters[1]);
  }
  const Tensor activation = Activation(node.op(), inputs[0]);
  if (activation.defined()) return activation;
  std::vector<Tensor> float32;
  float32.reserve(inputs.size());
  for (const Tensor& input : inputs) float32.push_back(input.to(at::kFloat));
  return Float32Op(node, float32, parameters);
}

}  // namespace sinew::learner
