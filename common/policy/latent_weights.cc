// What a policy with a latent begins with.

#include <cstdint>
#include <numbers>
#include <string>

#include "absl/status/statusor.h"
#include "absl/strings/match.h"
#include "absl/strings/string_view.h"
#include "common/policy/latent_builder.h"
#include "common/policy/layers.h"
#include "common/status_macros.h"

namespace sinew::policy {
namespace {

bool IsLastLayer(absl::string_view weight) {
  return absl::EndsWith(weight, "/mean/weight") ||
         absl::EndsWith(weight, "/log_variance/weight") ||
         weight == "decoder/action/weight";
}

double Gain(absl::string_view weight, const v1::Network& network) {
  if (weight == "critic/value/weight") return 1.0;
  return IsLastLayer(weight) ? network.last_layer_gain() : std::numbers::sqrt2;
}

double InitialConstant(absl::string_view name, const v1::Network& network) {
  if (name == "latent/half") return 0.5;
  if (name == "policy/std") return network.initial_std();
  return absl::EndsWith(name, "/inverse_std") ? 1.0 : 0.0;
}

}  // namespace

absl::StatusOr<TensorMap> InitialLatentWeights(
    const LatentPolicyOptions& options, uint64_t seed) {
  SINEW_ASSIGN_OR_RETURN(const v1::PolicyGraph graph,
                         BuildLatentPolicy(options));
  const v1::Network& network = options.network;
  return internal::DrawWeights(
      graph, seed,
      {.gain = [&](const std::string& name) { return Gain(name, network); },
       .constant =
           [&](const std::string& name) {
             return InitialConstant(name, network);
           }});
}

}  // namespace sinew::policy
