#include "tools/parity/latent_parts.h"

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/str_format.h"
#include "common/policy/latent_graphs.h"
#include "common/policy/ports.h"
#include "common/status_macros.h"
#include "tools/parity/bundle_parity.h"
#include "tools/parity/graph_rows.h"

namespace sinew::tools {
namespace {

// The graph of that name, which the bundle has.
const v1::Graph& GraphOf(const bundle::Bundle& bundle, const char* name) {
  const auto& graphs = bundle.graph.graphs();
  return *std::find_if(graphs.begin(), graphs.end(),
                       [&](const auto& graph) { return graph.name() == name; });
}

// The first `to` of each row's columns.
std::vector<float> Columns(const std::vector<float>& values, int rows,
                           size_t to) {
  std::vector<float> columns;
  const size_t width = values.size() / rows;
  for (auto row = values.begin(); row != values.end();
       row += static_cast<int64_t>(width)) {
    columns.insert(columns.end(), row, row + static_cast<int64_t>(to));
  }
  return columns;
}

}  // namespace

absl::StatusOr<LatentParts> CompareLatentParts(const bundle::Bundle& bundle,
                                               int rows, uint64_t seed) {
  const auto run = [&](const char* graph, const Rows& inputs) {
    return RunExecutor(bundle, graph, inputs, rows);
  };
  SINEW_ASSIGN_OR_RETURN(const policy::Ports ports,
                         policy::FindPorts(bundle.graph, "policy"));
  LatentParts differences;

  const Rows sampled =
      RandomInputs(GraphOf(bundle, policy::kSampleGraph), rows, seed);
  SINEW_ASSIGN_OR_RETURN(const Rows sample, run(policy::kSampleGraph, sampled));
  const std::vector<float>& own = sampled.at("self_observation");
  const std::vector<float>& noise = sampled.at("noise");
  SINEW_ASSIGN_OR_RETURN(const Rows prior,
                         run(policy::kPriorGraph, {{"self_observation", own}}));
  std::vector<float> latent = prior.at("mean");
  for (size_t i = 0; i < latent.size(); ++i) {
    latent[i] += prior.at("std")[i] * noise[i];
  }
  SINEW_ASSIGN_OR_RETURN(const Rows drawn,
                         run(policy::kDecoderGraph,
                             {{"self_observation", own}, {"latent", latent}}));
  differences.sample =
      ParityDifference(sample.at("action"), drawn.at("action"));

  Rows seen = RandomInputs(GraphOf(bundle, "policy"), rows, seed);
  for (const std::string& name : ports.noise) {
    std::fill(seen.at(name).begin(), seen.at(name).end(), 0.F);
  }
  const std::vector<float>& observation = seen.at(ports.observation);
  SINEW_ASSIGN_OR_RETURN(const Rows whole, run("policy", seen));
  SINEW_ASSIGN_OR_RETURN(
      const Rows encoder,
      run(policy::kEncoderGraph, {{"observation", observation}}));
  SINEW_ASSIGN_OR_RETURN(
      const Rows led,
      run(policy::kDecoderGraph,
          {{"self_observation", Columns(observation, rows, own.size() / rows)},
           {"latent", encoder.at("mean")}}));
  differences.policy =
      ParityDifference(whole.at(ports.action), led.at("action"));
  return differences;
}

absl::Status CheckLatentParts(const LatentParts& parts) {
  for (const auto& [graph, difference] :
       {std::pair("policy", parts.policy), std::pair("sample", parts.sample)}) {
    if (difference <= kParityTolerance) continue;
    return absl::InternalError(absl::StrFormat(
        "graph \"%s\": tap \"action\": expected what encoder, prior and "
        "decoder give within %.0e, found %.2e",
        graph, kParityTolerance, difference));
  }
  return absl::OkStatus();
}

}  // namespace sinew::tools
