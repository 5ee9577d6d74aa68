#include "tools/parity/bundle_parity.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <utility>

#include "absl/strings/str_format.h"
#include "absl/types/span.h"
#include "common/files.h"
#include "common/policy/executor.h"
#include "common/policy/safetensors.h"
#include "common/random/philox.h"
#include "common/status_macros.h"
#include "learner/torch/torch_runner.h"

namespace sinew::tools {
namespace {

constexpr char kGraph[] = "policy";

using Rows = std::map<std::string, std::vector<float>>;

Rows RandomInputs(const v1::Graph& graph, const ParityOptions& options) {
  Rows inputs;
  uint64_t number = 0;
  for (const v1::GraphInput& input : graph.inputs()) {
    std::vector<float>& values = inputs[input.name()];
    values.resize(options.rows * input.width());
    FillNormal({.seed = options.seed, .environment = number++},
               absl::MakeSpan(values));
    if (input.kind() != v1::GraphInput::KIND_DATA) continue;
    for (size_t i = 0; i < values.size(); ++i) {
      const size_t row = i / input.width();
      values[i] *= std::pow(10.F, static_cast<float>(row % 3) - 1.F);
    }
  }
  return inputs;
}

absl::StatusOr<Rows> RunExecutor(const bundle::Bundle& bundle,
                                 const v1::Graph& graph, const Rows& inputs,
                                 int rows) {
  SINEW_ASSIGN_OR_RETURN(
      const auto pack,
      policy::PackWeights(bundle.graph, kGraph, bundle.weights));
  SINEW_ASSIGN_OR_RETURN(const auto executor,
                         policy::Executor::Create(pack, rows));
  for (const auto& [name, values] : inputs) {
    std::copy(values.begin(), values.end(),
              executor->input(executor->input_index(name)).begin());
  }
  executor->Run(rows);
  Rows taps;
  for (const v1::Tap& tap : graph.taps()) {
    const auto values = executor->tap(executor->tap_index(tap.name()));
    taps[tap.name()].assign(values.begin(), values.end());
  }
  return taps;
}

absl::StatusOr<Rows> RunTorch(const bundle::Bundle& bundle, const Rows& inputs,
                              int rows) {
  SINEW_ASSIGN_OR_RETURN(
      const auto runner,
      learner::TorchRunner::Create(bundle.graph, kGraph, bundle.weights, {}));
  return runner->Run(rows, inputs);
}

absl::StatusOr<Rows> RunOnnxFile(const bundle::Bundle& bundle,
                                 const Rows& inputs,
                                 const OnnxRuntimeOptions& onnx, int rows) {
  OnnxJob job;
  job.model = JoinPath(bundle.directory, "policy.onnx");
  for (const auto& [name, values] : inputs) {
    const auto width = static_cast<int64_t>(values.size()) / rows;
    job.inputs[name] = HostTensor::Float32({rows, width}, values);
  }
  SINEW_ASSIGN_OR_RETURN(const std::vector<TensorMap> results,
                         RunOnnx(onnx, {job}));
  Rows taps;
  for (const auto& [name, tensor] : results[0]) {
    const auto values = tensor.float32();
    taps[name].assign(values.begin(), values.end());
  }
  return taps;
}

// Infinite where the other back end lacks the tap or gives another width.
double Difference(const std::vector<float>& expected, const Rows& other,
                  const std::string& tap) {
  const auto found = other.find(tap);
  if (found == other.end() || found->second.size() != expected.size()) {
    return INFINITY;
  }
  double largest = 0, scale = 0;
  for (size_t i = 0; i < expected.size(); ++i) {
    const double difference =
        std::abs(static_cast<double>(expected[i]) - found->second[i]);
    // Not std::max, which would lose a NaN.
    if (!(difference <= largest)) largest = difference;
    scale = std::max(scale, std::abs(static_cast<double>(expected[i])));
  }
  return scale > 0 ? largest / scale : largest;
}

}  // namespace

absl::StatusOr<std::vector<ParityRow>> CompareBackEnds(
    const bundle::Bundle& bundle, const ParityOptions& options) {
  SINEW_ASSIGN_OR_RETURN(const v1::Graph* graph,
                         policy::FindGraph(bundle.graph, kGraph));
  const Rows inputs = RandomInputs(*graph, options);
  SINEW_ASSIGN_OR_RETURN(const Rows own,
                         RunExecutor(bundle, *graph, inputs, options.rows));
  SINEW_ASSIGN_OR_RETURN(const Rows torch,
                         RunTorch(bundle, inputs, options.rows));
  std::optional<Rows> onnx;
  if (options.onnx) {
    SINEW_ASSIGN_OR_RETURN(
        onnx, RunOnnxFile(bundle, inputs, *options.onnx, options.rows));
  }
  std::vector<ParityRow> rows;
  for (const auto& [tap, values] : own) {
    ParityRow row = {.tap = tap, .torch = Difference(values, torch, tap)};
    if (onnx) row.onnx = Difference(values, *onnx, tap);
    rows.push_back(std::move(row));
  }
  return rows;
}

absl::Status CheckParity(const std::vector<ParityRow>& rows) {
  for (const ParityRow& row : rows) {
    for (const auto& [name, difference] :
         {std::pair("libtorch", row.torch),
          std::pair("onnxruntime", row.onnx.value_or(0))}) {
      if (difference <= kParityTolerance) continue;
      return absl::InternalError(absl::StrFormat(
          "tap \"%s\": expected %s within %.0e of the executor, found %.2e",
          row.tap, name, kParityTolerance, difference));
    }
  }
  return absl::OkStatus();
}

}  // namespace sinew::tools
