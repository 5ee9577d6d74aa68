#include "deploy/bundle/testing/toy_latent.h"

#include <string>
#include <utility>
#include <vector>

#include "absl/strings/match.h"
#include "absl/types/span.h"
#include "common/check.h"
#include "common/config/recipe.h"
#include "common/digest.h"
#include "common/files.h"
#include "common/policy/latent_builder.h"
#include "common/random/philox.h"
#include "deploy/bundle/content.h"
#include "deploy/bundle/testing/toy_bundle.h"

namespace sinew::bundle::testing {
namespace {

policy::LatentPolicyOptions Options(const LatentWidths& widths) {
  v1::Recipe recipe;
  v1::Network& network = *recipe.mutable_network();
  network.set_last_layer_gain(0.3);
  v1::Latent& latent = *network.mutable_latent();
  latent.set_width(static_cast<int32_t>(widths.latent));
  latent.add_encoder_hidden(12);
  latent.add_prior_hidden(12);
  latent.add_decoder_hidden(12);
  return {.self_observation_width = widths.self,
          .observation_width = widths.observation,
          .action_width = widths.action,
          .network = WithDefaults(std::move(recipe)).network()};
}

// Whether an untrained policy has the same numbers everywhere in it.
bool IsConstant(const std::string& name) {
  return absl::EndsWith(name, "/bias") || absl::StartsWith(name, "normaliser/");
}

}  // namespace

v1::PolicyGraph LatentGraphs(const LatentWidths& widths) {
  return policy::BuildLatentPolicy(Options(widths)).value();
}

TensorMap LatentWeights(const LatentWidths& widths) {
  TensorMap weights =
      policy::InitialLatentWeights(Options(widths), /*seed=*/3).value();
  uint64_t number = 0;
  for (auto& [name, tensor] : weights) {
    std::vector<float> noise(tensor.num_elements());
    FillNormal({.seed = 7,
                .environment = number++,
                .purpose = RandomPurpose::kInitialisation},
               absl::MakeSpan(noise));
    if (!IsConstant(name)) continue;
    const absl::Span<float> values = tensor.mutable_float32();
    for (size_t i = 0; i < values.size(); ++i) values[i] += 0.2F * noise[i];
  }
  return weights;
}

v1::Snapshot LatentSnapshot(const LatentWidths& widths) {
  v1::Snapshot snapshot;
  *snapshot.mutable_graph() = LatentGraphs(widths);
  snapshot.set_weights(SerializeSafetensors(LatentWeights(widths)));
  return snapshot;
}

v1::Recipe ToyLatentRecipe() {
  v1::Recipe recipe = world::testing::ToyRecipe();
  recipe.mutable_task()->mutable_action()->set_placement(
      v1::Action::PLACEMENT_AROUND_CURRENT);
  return recipe;
}

BundleContent ToyLatentContent(const world::testing::ToyWorld& toy,
                               const LatentWidths& widths) {
  ContentInputs inputs = ToyInputs(toy);
  const std::string snapshot =
      SerializeDeterministically(LatentSnapshot(widths));
  inputs.snapshot = snapshot;
  return MakeContent(inputs).value();
}

std::string WriteToyLatent(const world::testing::ToyWorld& toy,
                           const LatentWidths& widths) {
  const std::string directory = JoinPath(toy.folder, "bundle");
  const absl::Status written =
      WriteBundle(ToyLatentContent(toy, widths), directory);
  SINEW_CHECK(written.ok()) << written.ToString();
  return directory;
}

}  // namespace sinew::bundle::testing
