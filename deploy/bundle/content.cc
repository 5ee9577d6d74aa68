#include "deploy/bundle/content.h"

#include <mujoco/mujoco.h>

#include <set>

#include "absl/strings/str_cat.h"
#include "common/check.h"
#include "common/config/recipe.h"
#include "common/digest.h"
#include "common/policy/safetensors.h"
#include "common/status_macros.h"
#include "proto/sinew/v1/snapshot.pb.h"
#include "sim/world/observation.h"

namespace sinew::bundle {
namespace {

void AddJoints(const character::Character& character,
               v1::BundleManifest& manifest) {
  for (const character::JointInfo& joint : character.joints()) {
    v1::BundleJoint* to = manifest.add_joints();
    to->set_name(joint.name);
    to->set_stiffness(joint.stiffness);
    to->set_damping(joint.damping);
    to->set_torque_limit(joint.torque_limit);
    to->set_lower(joint.lower);
    to->set_upper(joint.upper);
    to->set_default_position(joint.default_position);
  }
}

void AddBodies(const character::Character& character,
               v1::BundleManifest& manifest) {
  for (int column : character.tracked()) {
    manifest.add_bodies(mj_id2name(character.model(), mjOBJ_BODY, column + 1));
  }
}

absl::Status AddTask(const ContentInputs& inputs,
                     v1::BundleManifest& manifest) {
  const v1::Recipe& recipe = inputs.recipe;
  const character::Character& character = *inputs.character;
  manifest.set_control_hz(recipe.physics().control_hz());
  manifest.set_physics_hz(recipe.physics().physics_hz());
  *manifest.mutable_physics() = recipe.physics();
  *manifest.mutable_task() = recipe.task();
  *manifest.mutable_observation() = recipe.task().observation();
  *manifest.mutable_action() = recipe.task().action();
  SINEW_ASSIGN_OR_RETURN(const world::ObservationBuilder observation,
                         world::ObservationBuilder::Create(
                             recipe.task().observation(),
                             static_cast<int>(character.tracked().size()),
                             static_cast<int>(character.joints().size()),
                             static_cast<int>(character.foot_bodies().size())));
  manifest.set_observation_width(observation.width());
  manifest.set_action_width(static_cast<int64_t>(character.joints().size()));
  return absl::OkStatus();
}

std::string OrUnknown(const std::string& text) {
  return text.empty() ? "unknown" : text;
}

void AddProvenance(const ContentInputs& inputs, v1::BundleManifest& manifest) {
  v1::BundleProvenance& provenance = *manifest.mutable_provenance();
  provenance.set_recipe(inputs.recipe.name());
  provenance.set_recipe_sha256(Sha256Hex(PrintRecipe(inputs.recipe)));
  provenance.set_library_sha256(inputs.library_sha256);
  std::set<std::string> licences;
  for (const v1::ClipInfo& clip : inputs.library.clips()) {
    provenance.add_clips(absl::StrCat(clip.name(), ": ",
                                      OrUnknown(clip.provenance()), " (",
                                      OrUnknown(clip.licence()), ")"));
    licences.insert(OrUnknown(clip.licence()));
  }
  licences.insert(OrUnknown(inputs.character->proto().licence()));
  for (const std::string& licence : licences) {
    provenance.add_data_licences(licence);
  }
  provenance.set_seed(inputs.recipe.seed());
  provenance.set_iterations(inputs.iterations);
  provenance.set_samples(inputs.samples);
  provenance.set_train_seconds(inputs.train_seconds);
  provenance.set_build(inputs.build);
  provenance.set_snapshot_sha256(Sha256Hex(inputs.snapshot));
}

}  // namespace

absl::StatusOr<BundleContent> MakeContent(const ContentInputs& inputs) {
  SINEW_CHECK(inputs.character != nullptr);
  v1::Snapshot snapshot;
  if (!snapshot.ParseFromArray(inputs.snapshot.data(),
                               static_cast<int>(inputs.snapshot.size()))) {
    return absl::InvalidArgumentError(
        absl::StrCat("snapshot: expected a v1.Snapshot, found ",
                     inputs.snapshot.size(), " bytes that are none"));
  }
  BundleContent content;
  content.graph = snapshot.graph();
  SINEW_ASSIGN_OR_RETURN(
      content.weights,
      ParseSafetensors(snapshot.weights(), "weights of the snapshot"));
  content.character_files = inputs.character_files;
  v1::BundleManifest& manifest = content.manifest;
  manifest.set_character(inputs.character->name());
  manifest.set_character_sha256(inputs.character->digest());
  AddJoints(*inputs.character, manifest);
  AddBodies(*inputs.character, manifest);
  SINEW_RETURN_IF_ERROR(AddTask(inputs, manifest));
  AddProvenance(inputs, manifest);
  return content;
}

}  // namespace sinew::bundle
