#include "tools/parity/latent_parts.h"

#include <algorithm>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/str_format.h"
#include "absl/types/span.h"
#include "common/policy/executor.h"
#include "common/policy/latent_graphs.h"
#include "common/policy/ports.h"
#include "common/random/philox.h"
#include "common/status_macros.h"
#include "tools/parity/bundle_parity.h"

namespace sinew::tools {
namespace {

using Values = std::vector<float>;  // [rows, width]

// One graph of a bundle, run by the executor.
class Part {
 public:
  static absl::StatusOr<Part> Create(const bundle::Bundle& bundle,
                                     const std::string& graph, int rows) {
    SINEW_ASSIGN_OR_RETURN(
        const auto pack,
        policy::PackWeights(bundle.graph, graph, bundle.weights));
    Part part;
    part.rows_ = rows;
    SINEW_ASSIGN_OR_RETURN(part.executor_,
                           policy::Executor::Create(pack, rows));
    return part;
  }

  int64_t width(const std::string& input) const {
    return executor_->input_width(executor_->input_index(input));
  }
  void Set(const std::string& input, const Values& values) {
    std::copy(values.begin(), values.end(),
              executor_->input(executor_->input_index(input)).begin());
  }
  void Run() { executor_->Run(rows_); }
  Values Tap(const std::string& tap) const {
    const auto values = executor_->tap(executor_->tap_index(tap));
    return {values.begin(), values.end()};
  }

 private:
  int rows_ = 0;
  std::unique_ptr<policy::Executor> executor_;
};

// Normal with standard deviations of 0.1, 1 and 10 in turn.
Values RandomObservations(int rows, int64_t width, uint64_t seed) {
  Values values(rows * width);
  FillNormal({.seed = seed}, absl::MakeSpan(values));
  for (size_t i = 0; i < values.size(); ++i) {
    const size_t row = i / width;
    values[i] *= row % 3 == 0 ? 0.1F : row % 3 == 1 ? 1.F : 10.F;
  }
  return values;
}

// The first `to` of each row's `from` columns.
Values Columns(const Values& values, int64_t from, int64_t to) {
  Values columns;
  for (size_t row = 0; row * from < values.size(); ++row) {
    const auto begin = values.begin() + static_cast<int64_t>(row) * from;
    columns.insert(columns.end(), begin, begin + to);
  }
  return columns;
}

}  // namespace

absl::StatusOr<LatentParts> CompareLatentParts(const bundle::Bundle& bundle,
                                               int rows, uint64_t seed) {
  SINEW_ASSIGN_OR_RETURN(const policy::Ports ports,
                         policy::FindPorts(bundle.graph, "policy"));
  SINEW_ASSIGN_OR_RETURN(Part whole, Part::Create(bundle, "policy", rows));
  SINEW_ASSIGN_OR_RETURN(Part encoder,
                         Part::Create(bundle, policy::kEncoderGraph, rows));
  SINEW_ASSIGN_OR_RETURN(Part prior,
                         Part::Create(bundle, policy::kPriorGraph, rows));
  SINEW_ASSIGN_OR_RETURN(Part decoder,
                         Part::Create(bundle, policy::kDecoderGraph, rows));
  SINEW_ASSIGN_OR_RETURN(Part sample,
                         Part::Create(bundle, policy::kSampleGraph, rows));
  const Values observation =
      RandomObservations(rows, ports.observation_width, seed);
  const Values own = Columns(observation, ports.observation_width,
                             decoder.width("self_observation"));
  LatentParts differences;

  whole.Set(ports.observation, observation);
  for (const std::string& noise : ports.noise) {
    whole.Set(noise, Values(rows * whole.width(noise)));
  }
  whole.Run();
  encoder.Set("observation", observation);
  encoder.Run();
  decoder.Set("self_observation", own);
  decoder.Set("latent", encoder.Tap("mean"));
  decoder.Run();
  differences.policy =
      ParityDifference(whole.Tap(ports.action), decoder.Tap("action"));

  Values noise(rows * sample.width("noise"));
  FillNormal({.seed = seed, .environment = 1}, absl::MakeSpan(noise));
  sample.Set("self_observation", own);
  sample.Set("noise", noise);
  sample.Run();
  prior.Set("self_observation", own);
  prior.Run();
  Values latent = prior.Tap("mean");
  const Values std = prior.Tap("std");
  for (size_t i = 0; i < latent.size(); ++i) latent[i] += std[i] * noise[i];
  decoder.Set("latent", latent);
  decoder.Run();
  differences.sample =
      ParityDifference(sample.Tap("action"), decoder.Tap("action"));
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
