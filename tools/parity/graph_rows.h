#ifndef SINEW_TOOLS_PARITY_GRAPH_ROWS_H_
#define SINEW_TOOLS_PARITY_GRAPH_ROWS_H_

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "deploy/bundle/bundle.h"
#include "proto/sinew/v1/graph.pb.h"

namespace sinew::tools {

// A graph's inputs, or its taps, by name: [rows, width] each, row-major.
using Rows = std::map<std::string, std::vector<float>>;

// All pure; errors of RunExecutor are the executor's.

// Data (observations, latents) are normal with standard deviations of 0.1, 1
// and 10 from row to row in turn, noise is N(0, 1): a function of graph, rows
// and seed.
Rows RandomInputs(const v1::Graph& graph, int rows, uint64_t seed);

// All taps of a bundle's graph. `inputs` has all of its inputs.
absl::StatusOr<Rows> RunExecutor(const bundle::Bundle& bundle,
                                 const std::string& graph, const Rows& inputs,
                                 int rows);

}  // namespace sinew::tools

#endif  // SINEW_TOOLS_PARITY_GRAPH_ROWS_H_
