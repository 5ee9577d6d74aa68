#include "deploy/runtime/latent_networks.h"

#include <algorithm>

#include "absl/memory/memory.h"
#include "absl/status/status.h"
#include "common/check.h"
#include "common/policy/latent_graphs.h"
#include "common/status_macros.h"
#include "deploy/bundle/latent_graphs.h"

namespace sinew::runtime {

void LatentNetworks::Network::Set(size_t input,
                                  absl::Span<const float> values) {
  const int index = inputs[input];
  const auto width = static_cast<size_t>(executor->input_width(index));
  SINEW_CHECK(values.size() == width);
  std::copy(values.begin(), values.end(), executor->input(index).begin());
}

void LatentNetworks::Network::Run() { executor->Run(1); }

absl::Span<const float> LatentNetworks::Network::Tap(size_t tap) const {
  const int index = taps[tap];
  return executor->tap(index).first(
      static_cast<size_t>(executor->tap_width(index)));
}

absl::StatusOr<LatentNetworks::Network> LatentNetworks::MakeNetwork(
    const bundle::Bundle& bundle, const std::string& graph,
    const std::vector<std::string>& inputs,
    const std::vector<std::string>& taps) {
  Network network;
  SINEW_ASSIGN_OR_RETURN(
      const auto pack,
      policy::PackWeights(bundle.graph, graph, bundle.weights));
  SINEW_ASSIGN_OR_RETURN(network.executor,
                         policy::Executor::Create(pack, /*max_batch=*/1));
  for (const std::string& input : inputs) {
    network.inputs.push_back(network.executor->input_index(input));
    SINEW_CHECK(network.inputs.back() >= 0) << graph << " " << input;
  }
  for (const std::string& tap : taps) {
    network.taps.push_back(network.executor->tap_index(tap));
    SINEW_CHECK(network.taps.back() >= 0) << graph << " " << tap;
  }
  return network;
}

absl::StatusOr<std::unique_ptr<LatentNetworks>> LatentNetworks::Create(
    const bundle::Bundle& bundle) {
  if (!bundle::HasLatent(bundle)) {
    return absl::FailedPreconditionError("this bundle has no latent");
  }
  auto made = absl::WrapUnique(new LatentNetworks());
  made->width_ = static_cast<int>(bundle.manifest.latent_width());
  SINEW_ASSIGN_OR_RETURN(made->encoder_,
                         MakeNetwork(bundle, policy::kEncoderGraph,
                                     {"observation"}, {"mean", "std"}));
  SINEW_ASSIGN_OR_RETURN(made->prior_,
                         MakeNetwork(bundle, policy::kPriorGraph,
                                     {"self_observation"}, {"mean", "std"}));
  SINEW_ASSIGN_OR_RETURN(
      made->decoder_, MakeNetwork(bundle, policy::kDecoderGraph,
                                  {"self_observation", "latent"}, {"action"}));
  SINEW_ASSIGN_OR_RETURN(
      made->sample_, MakeNetwork(bundle, policy::kSampleGraph,
                                 {"self_observation", "noise"}, {"action"}));
  return made;
}

LatentNetworks::Gaussian LatentNetworks::Encode(
    absl::Span<const float> observation) {
  encoder_.Set(0, observation);
  encoder_.Run();
  return {.mean = encoder_.Tap(0), .std = encoder_.Tap(1)};
}

LatentNetworks::Gaussian LatentNetworks::Prior(absl::Span<const float> own) {
  prior_.Set(0, own);
  prior_.Run();
  return {.mean = prior_.Tap(0), .std = prior_.Tap(1)};
}

absl::Span<const float> LatentNetworks::Decode(absl::Span<const float> own,
                                               absl::Span<const float> latent) {
  decoder_.Set(0, own);
  decoder_.Set(1, latent);
  decoder_.Run();
  return decoder_.Tap(0);
}

absl::Span<const float> LatentNetworks::Sample(absl::Span<const float> own,
                                               absl::Span<const float> noise) {
  sample_.Set(0, own);
  sample_.Set(1, noise);
  sample_.Run();
  return sample_.Tap(0);
}

}  // namespace sinew::runtime
