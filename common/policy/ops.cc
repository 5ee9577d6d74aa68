#include "common/policy/ops.h"

#include <cmath>
#include <string>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "absl/strings/string_view.h"
#include "common/policy/graph_error.h"
#include "common/status_macros.h"

namespace sinew::policy {
namespace {

using Shape = std::vector<int64_t>;

using internal::Bad;

std::string Text(const Shape& shape) {
  return absl::StrCat("[", absl::StrJoin(shape, ", "), "]");
}

// Which attributes an operation has.
enum Attributes : unsigned {
  kNone = 0,
  kLowHigh = 1,
  kBeginEnd = 2,
  kEpsilon = 4,
  kConvolution = 8,
};

// How many inputs and parameters an operation takes; -1: any number from the
// least on.
struct Rule {
  int least_inputs;
  int most_inputs;
  int least_parameters;
  int most_parameters;
  unsigned attributes;
};

absl::StatusOr<Rule> RuleOf(v1::Op op) {
  switch (op) {
    case v1::OP_AFFINE:
      return Rule{1, 1, 1, 2, kNone};
    case v1::OP_NORMALISE:
    case v1::OP_LINEAR:
      return Rule{1, 1, 2, 2, kNone};
    case v1::OP_CONV1D:
    case v1::OP_CONV1D_TRANSPOSE:
      return Rule{1, 1, 2, 2, kConvolution};
    case v1::OP_LAYER_NORM:
      return Rule{1, 1, 2, 2, kEpsilon};
    case v1::OP_RELU:
    case v1::OP_ELU:
    case v1::OP_SILU:
    case v1::OP_TANH:
    case v1::OP_SIGMOID:
    case v1::OP_SOFTMAX:
    case v1::OP_EXP:
      return Rule{1, 1, 0, 0, kNone};
    case v1::OP_CONCAT:
      return Rule{1, -1, 0, 0, kNone};
    case v1::OP_SLICE:
      return Rule{1, 1, 0, 0, kBeginEnd};
    case v1::OP_ADD:
    case v1::OP_SUBTRACT:
    case v1::OP_MULTIPLY:
      return Rule{2, 2, 0, 0, kNone};
    case v1::OP_CLAMP:
      return Rule{1, 1, 0, 0, kLowHigh};
    case v1::OP_L2_NORMALISE:
      return Rule{1, 1, 0, 0, kEpsilon};
    case v1::OP_ARGMIN:
    case v1::OP_GATHER:
      return Rule{1, 1, 1, 1, kNone};
    case v1::OP_WEIGHTED_SUM:
      return Rule{2, -1, 0, 0, kNone};
    default:
      return Bad("expected an operation, found op ", static_cast<int>(op));
  }
}

absl::Status CheckCount(absl::string_view what, int64_t found, int least,
                        int most) {
  if (found >= least && (most < 0 || found <= most)) return absl::OkStatus();
  if (most < 0) {
    return Bad("expected at least ", least, " ", what, ", found ", found);
  }
  if (least == most) {
    return Bad("expected ", least, " ", what, ", found ", found);
  }
  return Bad("expected ", least, " to ", most, " ", what, ", found ", found);
}

// An attribute that the operation lacks must be unset.
template <typename T>
absl::Status CheckUnset(absl::string_view name, T value, bool applies) {
  if (applies || value == 0) return absl::OkStatus();
  return Bad("attribute ", name, ": expected unset, found ", value);
}

absl::Status CheckAttributes(const v1::Node& node, unsigned attributes) {
  const bool low_high = attributes & kLowHigh;
  const bool begin_end = attributes & kBeginEnd;
  const bool epsilon = attributes & kEpsilon;
  const bool convolution = attributes & kConvolution;
  SINEW_RETURN_IF_ERROR(CheckUnset("low", node.low(), low_high));
  SINEW_RETURN_IF_ERROR(CheckUnset("high", node.high(), low_high));
  SINEW_RETURN_IF_ERROR(CheckUnset("begin", node.begin(), begin_end));
  SINEW_RETURN_IF_ERROR(CheckUnset("end", node.end(), begin_end));
  SINEW_RETURN_IF_ERROR(CheckUnset("epsilon", node.epsilon(), epsilon));
  SINEW_RETURN_IF_ERROR(CheckUnset("stride", node.stride(), convolution));
  SINEW_RETURN_IF_ERROR(CheckUnset("padding", node.padding(), convolution));
  SINEW_RETURN_IF_ERROR(CheckUnset("channels", node.channels(), convolution));
  if (low_high && !(node.low() < node.high())) {
    return Bad("attributes low and high: expected low < high, found ",
               node.low(), " and ", node.high());
  }
  if (epsilon && !(node.epsilon() > 0 && std::isfinite(node.epsilon()))) {
    return Bad("attribute epsilon: expected > 0 and finite, found ",
               node.epsilon());
  }
  return absl::OkStatus();
}

absl::Status CheckShape(absl::string_view what, const Shape& found,
                        const Shape& expected) {
  if (found == expected) return absl::OkStatus();
  return Bad(what, ": expected shape ", Text(expected), ", found ",
             Text(found));
}

absl::Status CheckRank(absl::string_view what, const Shape& found,
                       size_t rank) {
  if (found.size() == rank) return absl::OkStatus();
  return Bad(what, ": expected ", rank, " extents, found ", Text(found));
}

absl::StatusOr<int64_t> LinearWidth(int64_t width, const Shape& weight,
                                    const Shape& bias) {
  SINEW_RETURN_IF_ERROR(CheckRank("weight", weight, 2));
  SINEW_RETURN_IF_ERROR(CheckShape("weight", weight, {weight[0], width}));
  SINEW_RETURN_IF_ERROR(CheckShape("bias", bias, {weight[0]}));
  return weight[0];
}

absl::StatusOr<int64_t> ConvolutionWidth(const v1::Node& node, int64_t width,
                                         const Shape& weight,
                                         const Shape& bias) {
  const bool transpose = node.op() == v1::OP_CONV1D_TRANSPOSE;
  const int64_t channels = node.channels();
  const int64_t stride = node.stride();
  const int64_t padding = node.padding();
  if (stride < 1 || stride > kMaxWidth || padding < 0 || padding > kMaxWidth) {
    return Bad("attributes stride and padding: expected >= 1 and >= 0, found ",
               stride, " and ", padding);
  }
  if (channels < 1 || width % channels != 0) {
    return Bad("attribute channels: expected a divisor of the input's width ",
               width, ", found ", channels);
  }
  SINEW_RETURN_IF_ERROR(CheckRank("weight", weight, 3));
  const int64_t out = transpose ? weight[1] : weight[0];
  const Shape expected = transpose ? Shape{channels, out, weight[2]}
                                   : Shape{out, channels, weight[2]};
  SINEW_RETURN_IF_ERROR(CheckShape("weight", weight, expected));
  SINEW_RETURN_IF_ERROR(CheckShape("bias", bias, {out}));
  const int64_t length = width / channels;
  const int64_t span = length + 2 * padding - weight[2];
  const int64_t out_length =
      transpose ? (length - 1) * stride - 2 * padding + weight[2]
                : (span < 0 ? 0 : span / stride + 1);
  if (out_length < 1) {
    return Bad("expected a result of length >= 1, found ", out_length);
  }
  if (out_length > kMaxWidth / out) {
    return Bad("expected a width of at most ", kMaxWidth, ", found ", out,
               " x ", out_length);
  }
  if (out_length > kMaxParameterElements / (channels * weight[2])) {
    return Bad("expected length x channels x kernel of at most ",
               kMaxParameterElements, ", found ", out_length, " x ", channels,
               " x ", weight[2]);
  }
  return out * out_length;
}

absl::StatusOr<int64_t> EqualWidth(absl::Span<const int64_t> widths,
                                   size_t first) {
  for (size_t i = first; i < widths.size(); ++i) {
    if (widths[i] != widths[first]) {
      return Bad("expected inputs of equal width, found ", widths[first],
                 " and ", widths[i]);
    }
  }
  return widths[first];
}

absl::StatusOr<int64_t> WeightedSumWidth(absl::Span<const int64_t> widths) {
  const int64_t terms = static_cast<int64_t>(widths.size()) - 1;
  if (widths[0] != terms) {
    return Bad("expected one weight for each of ", terms,
               " inputs, found a first input of width ", widths[0]);
  }
  return EqualWidth(widths, 1);
}

absl::StatusOr<int64_t> ConcatWidth(absl::Span<const int64_t> widths) {
  int64_t total = 0;
  for (const int64_t width : widths) {
    total += width;
    if (total > kMaxWidth) {
      return Bad("expected a width of at most ", kMaxWidth, ", found more");
    }
  }
  return total;
}

absl::StatusOr<int64_t> SliceWidth(const v1::Node& node, int64_t width) {
  if (node.begin() < 0 || node.begin() >= node.end() || node.end() > width) {
    return Bad("attributes begin and end: expected 0 <= begin < end <= ", width,
               ", found ", node.begin(), " and ", node.end());
  }
  return node.end() - node.begin();
}

// Every parameter is [width] and the result as wide as x.
absl::StatusOr<int64_t> ColumnWise(int64_t width,
                                   absl::Span<const Shape> parameters) {
  for (size_t i = 0; i < parameters.size(); ++i) {
    SINEW_RETURN_IF_ERROR(
        CheckShape(absl::StrCat("parameter ", i), parameters[i], {width}));
  }
  return width;
}

}  // namespace

absl::StatusOr<int64_t> NodeWidth(
    const v1::Node& node, absl::Span<const int64_t> input_widths,
    absl::Span<const std::vector<int64_t>> parameter_shapes) {
  SINEW_ASSIGN_OR_RETURN(const Rule rule, RuleOf(node.op()));
  SINEW_RETURN_IF_ERROR(CheckCount("inputs", input_widths.size(),
                                   rule.least_inputs, rule.most_inputs));
  SINEW_RETURN_IF_ERROR(CheckCount("parameters", parameter_shapes.size(),
                                   rule.least_parameters,
                                   rule.most_parameters));
  SINEW_RETURN_IF_ERROR(CheckAttributes(node, rule.attributes));
  const int64_t width = input_widths[0];
  switch (node.op()) {
    case v1::OP_LINEAR:
      return LinearWidth(width, parameter_shapes[0], parameter_shapes[1]);
    case v1::OP_CONV1D:
    case v1::OP_CONV1D_TRANSPOSE:
      return ConvolutionWidth(node, width, parameter_shapes[0],
                              parameter_shapes[1]);
    case v1::OP_CONCAT:
      return ConcatWidth(input_widths);
    case v1::OP_SLICE:
      return SliceWidth(node, width);
    case v1::OP_ADD:
    case v1::OP_SUBTRACT:
    case v1::OP_MULTIPLY:
      return EqualWidth(input_widths, 0);
    case v1::OP_WEIGHTED_SUM:
      return WeightedSumWidth(input_widths);
    case v1::OP_ARGMIN:
      SINEW_RETURN_IF_ERROR(CheckRank("codebook", parameter_shapes[0], 2));
      SINEW_RETURN_IF_ERROR(CheckShape("codebook", parameter_shapes[0],
                                       {parameter_shapes[0][0], width}));
      return 1;
    case v1::OP_GATHER:
      SINEW_RETURN_IF_ERROR(CheckRank("codebook", parameter_shapes[0], 2));
      if (width != 1) return Bad("expected an input of width 1, found ", width);
      return parameter_shapes[0][1];
    default:
      return ColumnWise(width, parameter_shapes);
  }
}

}  // namespace sinew::policy
