#include "tools/parity/bundle_parity.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <utility>

#include "absl/strings/str_format.h"
#include "absl/types/span.h"
#include "common/policy/safetensors.h"
#include "common/status_macros.h"
#include "learner/torch/torch_runner.h"
#include "tools/parity/graph_rows.h"

namespace sinew::tools {
namespace {

absl::StatusOr<Rows> RunTorch(const bundle::Bundle& bundle,
                              const v1::Graph& graph, const Rows& inputs,
                              int rows) {
  SINEW_ASSIGN_OR_RETURN(const auto runner,
                         learner::TorchRunner::Create(
                             bundle.graph, graph.name(), bundle.weights, {}));
  return runner->Run(rows, inputs);
}

OnnxJob MakeJob(const bundle::Bundle& bundle, const v1::Graph& graph,
                const Rows& inputs, int rows) {
  OnnxJob job;
  job.model = bundle.onnx_file(graph.name());
  for (const auto& [name, values] : inputs) {
    const auto width = static_cast<int64_t>(values.size()) / rows;
    job.inputs[name] = HostTensor::Float32({rows, width}, values);
  }
  return job;
}

Rows FromTensors(const TensorMap& tensors) {
  Rows rows;
  for (const auto& [name, tensor] : tensors) {
    const auto values = tensor.float32();
    rows[name].assign(values.begin(), values.end());
  }
  return rows;
}

// Infinite where the other back end lacks the tap.
double Difference(const std::vector<float>& expected, const Rows& other,
                  const std::string& tap) {
  const auto found = other.find(tap);
  return found == other.end() ? INFINITY
                              : ParityDifference(expected, found->second);
}

// The rows of a graph, without onnxruntime; `own`: what the executor gave.
absl::StatusOr<std::vector<ParityRow>> CompareTorch(
    const bundle::Bundle& bundle, const v1::Graph& graph, const Rows& inputs,
    int batch, Rows* own) {
  SINEW_ASSIGN_OR_RETURN(*own,
                         RunExecutor(bundle, graph.name(), inputs, batch));
  SINEW_ASSIGN_OR_RETURN(const Rows torch,
                         RunTorch(bundle, graph, inputs, batch));
  std::vector<ParityRow> rows;
  for (const auto& [tap, values] : *own) {
    rows.push_back({.graph = graph.name(),
                    .tap = tap,
                    .torch = Difference(values, torch, tap)});
  }
  return rows;
}

}  // namespace

double ParityDifference(absl::Span<const float> expected,
                        absl::Span<const float> found) {
  if (expected.size() != found.size()) return INFINITY;
  double largest = 0, scale = 0;
  for (size_t i = 0; i < expected.size(); ++i) {
    const double difference =
        std::abs(static_cast<double>(expected[i]) - found[i]);
    // std::max would lose a NaN.
    if (!std::isfinite(difference)) return INFINITY;
    largest = std::max(largest, difference);
    scale = std::max(scale, std::abs(static_cast<double>(expected[i])));
  }
  return scale > 0 ? largest / scale : largest;
}

absl::StatusOr<std::vector<ParityRow>> CompareBackEnds(
    const bundle::Bundle& bundle, const ParityOptions& options) {
  std::vector<ParityRow> rows;
  std::map<std::string, Rows> own;  // by graph
  std::vector<OnnxJob> jobs;
  for (const v1::Graph& graph : bundle.graph.graphs()) {
    const Rows inputs = RandomInputs(graph, options.rows, options.seed);
    SINEW_ASSIGN_OR_RETURN(
        const std::vector<ParityRow> more,
        CompareTorch(bundle, graph, inputs, options.rows, &own[graph.name()]));
    rows.insert(rows.end(), more.begin(), more.end());
    jobs.push_back(MakeJob(bundle, graph, inputs, options.rows));
  }
  if (!options.onnx) return rows;
  // One process for all models: it takes seconds to start.
  SINEW_ASSIGN_OR_RETURN(const std::vector<TensorMap> results,
                         RunOnnx(*options.onnx, jobs));
  std::map<std::string, Rows> onnx;
  for (int i = 0; i < bundle.graph.graphs_size(); ++i) {
    onnx[bundle.graph.graphs(i).name()] = FromTensors(results[i]);
  }
  for (ParityRow& row : rows) {
    row.onnx =
        Difference(own.at(row.graph).at(row.tap), onnx.at(row.graph), row.tap);
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
          "graph \"%s\": tap \"%s\": expected %s within %.0e of the executor, "
          "found %.2e",
          row.graph, row.tap, name, kParityTolerance, difference));
    }
  }
  return absl::OkStatus();
}

}  // namespace sinew::tools
