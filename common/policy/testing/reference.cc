#include "common/policy/testing/reference.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "common/check.h"

namespace sinew::policy::testing {
namespace {

using Row = std::vector<double>;

// Element [i, j, ...] of a parameter.
class Parameter {
 public:
  explicit Parameter(const HostTensor& tensor) : tensor_(tensor) {}
  int64_t extent(int axis) const { return tensor_.shape[axis]; }
  double at(int64_t i) const { return tensor_.float32()[i]; }
  double at(int64_t i, int64_t j) const { return at(i * extent(1) + j); }
  double at(int64_t i, int64_t j, int64_t k) const {
    return at((i * extent(1) + j) * extent(2) + k);
  }

 private:
  const HostTensor& tensor_;
};

using Parameters = std::vector<Parameter>;

template <typename F>
Row Map(const Row& x, F f) {
  Row y;
  for (const double element : x) y.push_back(f(element));
  return y;
}

template <typename F>
Row Zip(const Row& a, const Row& b, F f) {
  Row y;
  for (size_t i = 0; i < a.size(); ++i) y.push_back(f(a[i], b[i]));
  return y;
}

Row Affine(const Row& x, const Parameters& p) {
  Row y;
  for (size_t i = 0; i < x.size(); ++i) {
    y.push_back(x[i] * p[0].at(i) + (p.size() > 1 ? p[1].at(i) : 0.0));
  }
  return y;
}

Row Normalise(const Row& x, const Parameters& p) {
  Row y;
  for (size_t i = 0; i < x.size(); ++i) {
    y.push_back((x[i] - p[0].at(i)) * p[1].at(i));
  }
  return y;
}

Row Linear(const Row& x, const Parameters& p) {
  Row y;
  for (int64_t o = 0; o < p[0].extent(0); ++o) {
    double sum = p[1].at(o);
    for (size_t i = 0; i < x.size(); ++i) sum += x[i] * p[0].at(o, i);
    y.push_back(sum);
  }
  return y;
}

Row Conv1d(const v1::Node& node, const Row& x, const Parameters& p) {
  const int64_t length = x.size() / node.channels();
  const int64_t out_length =
      (length + 2 * node.padding() - p[0].extent(2)) / node.stride() + 1;
  Row y;
  for (int64_t o = 0; o < p[0].extent(0); ++o) {
    for (int64_t t = 0; t < out_length; ++t) {
      double sum = p[1].at(o);
      for (int64_t c = 0; c < node.channels(); ++c) {
        for (int64_t k = 0; k < p[0].extent(2); ++k) {
          const int64_t at = t * node.stride() + k - node.padding();
          if (at < 0 || at >= length) continue;
          sum += x[c * length + at] * p[0].at(o, c, k);
        }
      }
      y.push_back(sum);
    }
  }
  return y;
}

// By scattering, where the executor gathers.
Row Conv1dTranspose(const v1::Node& node, const Row& x, const Parameters& p) {
  const int64_t length = x.size() / node.channels();
  const int64_t out = p[0].extent(1);
  const int64_t out_length =
      (length - 1) * node.stride() - 2 * node.padding() + p[0].extent(2);
  Row y;
  for (int64_t o = 0; o < out; ++o) y.insert(y.end(), out_length, p[1].at(o));
  for (int64_t c = 0; c < node.channels(); ++c) {
    for (int64_t l = 0; l < length; ++l) {
      for (int64_t k = 0; k < p[0].extent(2); ++k) {
        const int64_t t = l * node.stride() + k - node.padding();
        if (t < 0 || t >= out_length) continue;
        for (int64_t o = 0; o < out; ++o) {
          y[o * out_length + t] += x[c * length + l] * p[0].at(c, o, k);
        }
      }
    }
  }
  return y;
}

Row LayerNorm(const v1::Node& node, const Row& x, const Parameters& p) {
  double mean = 0;
  const double count = static_cast<double>(x.size());
  for (const double element : x) mean += element / count;
  double variance = 0;
  for (const double element : x) {
    variance += (element - mean) * (element - mean) / count;
  }
  Row y;
  for (size_t i = 0; i < x.size(); ++i) {
    y.push_back((x[i] - mean) / std::sqrt(variance + node.epsilon()) *
                    p[0].at(i) +
                p[1].at(i));
  }
  return y;
}

Row Softmax(const Row& x) {
  const double most = *std::max_element(x.begin(), x.end());
  double sum = 0;
  for (const double element : x) sum += std::exp(element - most);
  return Map(x, [&](double element) { return std::exp(element - most) / sum; });
}

Row L2Normalise(const v1::Node& node, const Row& x) {
  double sum = 0;
  for (const double element : x) sum += element * element;
  const double norm = std::max(std::sqrt(sum), node.epsilon());
  return Map(x, [&](double element) { return element / norm; });
}

Row Argmin(const Row& x, const Parameters& p) {
  double least = std::numeric_limits<double>::infinity();
  double nearest = 0;
  for (int64_t code = 0; code < p[0].extent(0); ++code) {
    double distance = 0;
    for (size_t i = 0; i < x.size(); ++i) {
      distance += (x[i] - p[0].at(code, i)) * (x[i] - p[0].at(code, i));
    }
    if (distance < least) {
      least = distance;
      nearest = static_cast<double>(code);
    }
  }
  return {nearest};
}

Row Gather(const Row& x, const Parameters& p) {
  Row y;
  for (int64_t i = 0; i < p[0].extent(1); ++i) {
    y.push_back(p[0].at(static_cast<int64_t>(x[0]), i));
  }
  return y;
}

Row WeightedSum(const std::vector<Row>& inputs) {
  Row y(inputs[1].size(), 0.0);
  for (size_t e = 0; e + 1 < inputs.size(); ++e) {
    for (size_t i = 0; i < y.size(); ++i) {
      y[i] += inputs[0][e] * inputs[e + 1][i];
    }
  }
  return y;
}

Row Concat(const std::vector<Row>& inputs) {
  Row y;
  for (const Row& input : inputs) y.insert(y.end(), input.begin(), input.end());
  return y;
}

Row Sigmoid(const Row& x) {
  return Map(x, [](double v) { return 1 / (1 + std::exp(-v)); });
}

Row Evaluate(const v1::Node& node, const std::vector<Row>& in,
             const Parameters& p) {
  const Row& x = in[0];
  switch (node.op()) {
    case v1::OP_AFFINE:
      return Affine(x, p);
    case v1::OP_NORMALISE:
      return Normalise(x, p);
    case v1::OP_LINEAR:
      return Linear(x, p);
    case v1::OP_CONV1D:
      return Conv1d(node, x, p);
    case v1::OP_CONV1D_TRANSPOSE:
      return Conv1dTranspose(node, x, p);
    case v1::OP_LAYER_NORM:
      return LayerNorm(node, x, p);
    case v1::OP_RELU:
      return Map(x, [](double v) { return std::max(v, 0.0); });
    case v1::OP_ELU:
      return Map(x, [](double v) { return v > 0 ? v : std::expm1(v); });
    case v1::OP_SILU:
      return Zip(x, Sigmoid(x), std::multiplies<>());
    case v1::OP_TANH:
      return Map(x, [](double v) { return std::tanh(v); });
    case v1::OP_SIGMOID:
      return Sigmoid(x);
    case v1::OP_SOFTMAX:
      return Softmax(x);
    case v1::OP_CONCAT:
      return Concat(in);
    case v1::OP_SLICE:
      return Row(x.begin() + node.begin(), x.begin() + node.end());
    case v1::OP_ADD:
      return Zip(x, in[1], std::plus<>());
    case v1::OP_SUBTRACT:
      return Zip(x, in[1], std::minus<>());
    case v1::OP_MULTIPLY:
      return Zip(x, in[1], std::multiplies<>());
    case v1::OP_CLAMP:
      return Map(
          x, [&](double v) { return std::clamp(v, node.low(), node.high()); });
    case v1::OP_EXP:
      return Map(x, [](double v) { return std::exp(v); });
    case v1::OP_L2_NORMALISE:
      return L2Normalise(node, x);
    case v1::OP_ARGMIN:
      return Argmin(x, p);
    case v1::OP_GATHER:
      return Gather(x, p);
    case v1::OP_WEIGHTED_SUM:
      return WeightedSum(in);
    default:
      SINEW_CHECK(false) << v1::Op_Name(node.op());
      return {};
  }
}

// All values of one row, by name.
std::map<std::string, Row> EvaluateRow(const v1::Graph& graph,
                                       const TensorMap& weights,
                                       const ReferenceValues& inputs, int row) {
  std::map<std::string, Row> values;
  for (const v1::GraphInput& input : graph.inputs()) {
    const auto begin = inputs.at(input.name()).begin() + row * input.width();
    values[input.name()] = Row(begin, begin + input.width());
  }
  for (const v1::Node& node : graph.nodes()) {
    std::vector<Row> in;
    for (const std::string& name : node.inputs()) in.push_back(values.at(name));
    Parameters parameters;
    for (const std::string& name : node.parameters()) {
      parameters.emplace_back(weights.at(name));
    }
    values[node.name()] = Evaluate(node, in, parameters);
  }
  return values;
}

}  // namespace

ReferenceValues RunReference(const v1::PolicyGraph& graph,
                             absl::string_view graph_name,
                             const TensorMap& weights,
                             const ReferenceValues& inputs, int batch) {
  ReferenceValues taps;
  for (const v1::Graph& one : graph.graphs()) {
    if (one.name() != graph_name) continue;
    for (int row = 0; row < batch; ++row) {
      const auto values = EvaluateRow(one, weights, inputs, row);
      for (const v1::Tap& tap : one.taps()) {
        const Row& value = values.at(tap.value());
        Row& rows = taps[tap.name()];
        rows.insert(rows.end(), value.begin(), value.end());
      }
    }
  }
  return taps;
}

double RelativeDifference(absl::Span<const float> actual,
                          absl::Span<const double> expected) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  if (actual.size() != expected.size()) return kInfinity;
  double most = 0;
  double scale = std::numeric_limits<double>::min();
  for (size_t i = 0; i < actual.size(); ++i) {
    const double difference = std::abs(actual[i] - expected[i]);
    if (!std::isfinite(difference)) return kInfinity;
    most = std::max(most, difference);
    scale = std::max(scale, std::abs(expected[i]));
  }
  return most / scale;
}

double RelativeDifference(absl::Span<const float> actual,
                          absl::Span<const float> expected) {
  return RelativeDifference(
      actual, std::vector<double>(expected.begin(), expected.end()));
}

}  // namespace sinew::policy::testing
