#include "deploy/bundle/testing/toy_bundle.h"

#include <memory>
#include <utility>

#include "common/config/recipe.h"
#include "common/digest.h"
#include "common/files.h"
#include "common/policy/builder.h"
#include "common/policy/safetensors.h"
#include "common/policy/select_graphs.h"
#include "sim/character/character_files.h"
#include "sim/world/observation.h"

namespace sinew::bundle::testing {
namespace {

int64_t ObservationWidth(const v1::Recipe& recipe,
                         const character::Character& character) {
  return world::ObservationBuilder::Create(
             recipe.task().observation(),
             static_cast<int>(character.tracked().size()),
             static_cast<int>(character.joints().size()),
             static_cast<int>(character.foot_bodies().size()))
      .value()
      .width();
}

BundleContent Content(ContentInputs inputs, double gain) {
  const v1::Snapshot snapshot = RandomSnapshot(
      inputs.recipe, ObservationWidth(inputs.recipe, *inputs.character),
      static_cast<int64_t>(inputs.character->joints().size()), gain);
  const std::string bytes = SerializeDeterministically(snapshot);
  inputs.snapshot = bytes;
  inputs.iterations = 3;
  inputs.samples = 6144;
  inputs.train_seconds = 1.5;
  inputs.build = "none";
  return MakeContent(inputs).value();
}

}  // namespace

v1::Snapshot RandomSnapshot(const v1::Recipe& recipe, int64_t observation_width,
                            int64_t action_width, double gain) {
  policy::TrackingPolicyOptions options;
  options.observation_width = observation_width;
  options.action_width = action_width;
  options.network = recipe.network();
  options.network.set_last_layer_gain(gain);
  v1::Snapshot snapshot;
  *snapshot.mutable_graph() = policy::GraphsWithout(
      policy::BuildTrackingPolicy(options).value(), {"critic"});
  snapshot.set_weights(SerializeSafetensors(policy::WeightsOf(
      snapshot.graph(), policy::InitialWeights(options, /*seed=*/3).value())));
  return snapshot;
}

ContentInputs ToyInputs(const world::testing::ToyWorld& toy) {
  ContentInputs inputs;
  inputs.recipe = toy.recipe;
  inputs.character = toy.character.get();
  inputs.character_files =
      character::CharacterFiles(JoinPath(toy.folder, "character.textproto"))
          .value();
  inputs.library = toy.library->manifest();
  inputs.library_sha256 = toy.library->digest();
  return inputs;
}

BundleContent ToyContent(const world::testing::ToyWorld& toy, double gain) {
  return Content(ToyInputs(toy), gain);
}

BundleContent CharacterContent(const std::string& name,
                               const v1::Recipe& recipe) {
  const std::unique_ptr<character::Character> character =
      character::Character::Load(name, recipe.physics()).value();
  ContentInputs inputs;
  inputs.recipe = recipe;
  inputs.character = character.get();
  inputs.character_files = character::CharacterFiles(name).value();
  return Content(std::move(inputs), /*gain=*/0.3);
}

}  // namespace sinew::bundle::testing
