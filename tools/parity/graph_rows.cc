#include "tools/parity/graph_rows.h"

#include <algorithm>
#include <cmath>

#include "absl/types/span.h"
#include "common/policy/executor.h"
#include "common/random/philox.h"
#include "common/status_macros.h"

namespace sinew::tools {

Rows RandomInputs(const v1::Graph& graph, int rows, uint64_t seed) {
  Rows inputs;
  uint64_t number = 0;
  for (const v1::GraphInput& input : graph.inputs()) {
    std::vector<float>& values = inputs[input.name()];
    values.resize(rows * input.width());
    FillNormal({.seed = seed, .environment = number++}, absl::MakeSpan(values));
    if (input.kind() != v1::GraphInput::KIND_DATA) continue;
    for (size_t i = 0; i < values.size(); ++i) {
      const size_t row = i / input.width();
      values[i] *= std::pow(10.F, static_cast<float>(row % 3) - 1.F);
    }
  }
  return inputs;
}

absl::StatusOr<Rows> RunExecutor(const bundle::Bundle& bundle,
                                 const std::string& graph, const Rows& inputs,
                                 int rows) {
  SINEW_ASSIGN_OR_RETURN(
      const auto pack,
      policy::PackWeights(bundle.graph, graph, bundle.weights));
  SINEW_ASSIGN_OR_RETURN(const auto executor,
                         policy::Executor::Create(pack, rows));
  for (const auto& [name, values] : inputs) {
    std::copy(values.begin(), values.end(),
              executor->input(executor->input_index(name)).begin());
  }
  executor->Run(rows);
  Rows taps;
  for (const v1::Graph& one : bundle.graph.graphs()) {
    if (one.name() != graph) continue;
    for (const v1::Tap& tap : one.taps()) {
      const auto values = executor->tap(executor->tap_index(tap.name()));
      taps[tap.name()].assign(values.begin(), values.end());
    }
  }
  return taps;
}

}  // namespace sinew::tools
