#ifndef SINEW_COMMON_POLICY_OPS_H_
#define SINEW_COMMON_POLICY_OPS_H_

#include <cstdint>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/types/span.h"
#include "proto/sinew/v1/graph.pb.h"

namespace sinew::policy {

// Semantics of the operations that graph.proto leaves open. All back ends
// (executor.h, learner/torch, onnx/) and the reference in testing/ agree on
// them. x is the first input; i, k count from 0; arithmetic is float32.
//
//   AFFINE           x * scale + shift; with one parameter: x * scale
//   NORMALISE        (x - mean) * inverse_std, in this order
//   CONV1D           x is [channels, length], length = width / channels;
//                    y[o, t] = bias[o] + sum over c, k of
//                    x[c, t * stride + k - padding] * weight[o, c, k], zeros
//                    outside; t < (length + 2 padding - kernel) / stride + 1,
//                    rounded down; y is [out, t] row-major
//   CONV1D_TRANSPOSE y[o, t] = bias[o] + sum over c, l, k with
//                    l * stride + k - padding = t of x[c, l] * weight[c, o, k];
//                    t < (length - 1) * stride - 2 padding + kernel
//   LAYER_NORM       (x - m) / sqrt(v + epsilon) * gain + bias, with m, v mean
//                    and biased variance over the width
//   ELU              x > 0 ? x : exp(x) - 1, accurate near 0
//   SILU             x / (1 + exp(-x))
//   SOFTMAX          over the whole width, the maximum subtracted first
//   CLAMP            low < high, either may be infinite
//   L2_NORMALISE     x / max(sqrt(sum x^2), epsilon), epsilon > 0
//   ARGMIN           squared distances summed over k; x of width K against
//                    codebook[n, K]; result of width 1
//   GATHER           x truncated to an integer; outside [0, n) every element
//                    of the row is NaN
//   WEIGHTED_SUM     sum over i of weights[i] * input[i + 1]
//
// NaN in an element of x gives NaN wherever the result depends on it (ARGMIN:
// NaN; GATHER: a NaN row).

// Largest width of a value, sum of the widths of a graph, and number of
// elements of a parameter: a graph from outside cannot make a reader allocate
// without bound.
inline constexpr int64_t kMaxWidth = int64_t{1} << 22;
inline constexpr int64_t kMaxTotalWidth = int64_t{1} << 24;
inline constexpr int64_t kMaxParameterElements = int64_t{1} << 28;

// Width of a node's result, given the widths of its inputs and the shapes of
// its parameters, after checking their number, the shapes and the attributes.
// INVALID_ARGUMENT says what was expected and found; the caller adds where.
absl::StatusOr<int64_t> NodeWidth(
    const v1::Node& node, absl::Span<const int64_t> input_widths,
    absl::Span<const std::vector<int64_t>> parameter_shapes);

}  // namespace sinew::policy

#endif  // SINEW_COMMON_POLICY_OPS_H_
