#include "deploy/bundle/content.h"

#include <mujoco/mujoco.h>

#include <set>

#include "absl/strings/str_cat.h"
#include "common/check.h"
#include "common/config/recipe.h"
#include "common/digest.h"
#include "common/policy/safetensors.h"
#include "common/policy/select_graphs.h"
#include "common/status_macros.h"
#include "deploy/bundle/clip_uses.h"
#include "deploy/bundle/latent_graphs.h"
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
    to->set_action_scale(joint.action_scale);
  }
}

void AddBodies(const character::Character& character,
               v1::BundleManifest& manifest) {
  for (int column : character.tracked()) {
    manifest.add_bodies(mj_id2name(character.model(), mjOBJ_BODY, column + 1));
  }
}

absl::Status AddTask(const ContentInputs& inputs, const v1::PolicyGraph& graph,
                     v1::BundleManifest& manifest) {
  const v1::Recipe& recipe = inputs.recipe;
  const character::Character& character = *inputs.character;
  manifest.set_control_hz(recipe.physics().control_hz());
  manifest.set_physics_hz(recipe.physics().physics_hz());
  *manifest.mutable_physics() = recipe.physics();
  *manifest.mutable_task() = recipe.task();
  *manifest.mutable_observation() = recipe.task().observation();
  *manifest.mutable_action() = recipe.task().action();
  const v1::Recipe usual = TaskRecipe(manifest);
  if (const double distance = recipe.evaluation().max_mean_body_distance();
      distance != usual.evaluation().max_mean_body_distance()) {
    manifest.set_max_mean_body_distance(distance);
  }
  SINEW_ASSIGN_OR_RETURN(const world::ObservationBuilder observation,
                         world::ObservationBuilder::Create(
                             recipe.task().observation(),
                             static_cast<int>(character.tracked().size()),
                             static_cast<int>(character.joints().size()),
                             static_cast<int>(character.foot_bodies().size())));
  manifest.set_observation_width(observation.width());
  const int64_t latent_width = LatentWidth(graph);
  if (latent_width > 0) {
    manifest.set_self_observation_width(observation.self_width());
    manifest.set_latent_width(latent_width);
  }
  manifest.set_action_width(static_cast<int64_t>(character.joints().size()));
  return absl::OkStatus();
}

// What went into the weights, directly or by way of other bundles.
void AddData(const ContentInputs& inputs, v1::BundleProvenance& provenance) {
  std::set<std::string> licences = {
      OrUnknown(inputs.character->proto().licence())};
  std::set<std::string> known;
  const auto add = [&](const std::string& clip) {
    if (known.insert(clip).second) provenance.add_clips(clip);
  };
  for (const v1::ClipInfo& clip : inputs.library.clips()) {
    add(ClipEntryOf(clip));
    licences.insert(OrUnknown(clip.licence()));
  }
  const std::set<std::string> own = known;
  for (const v1::RunInputs::Source& source : inputs.sources) {
    for (const std::string& clip : source.clips()) add(clip);
    if (!source.has_bundle()) continue;  // the run itself, and its own clips
    v1::BundleSource& named = *provenance.add_sources();
    named = source.bundle();
    if (!source.labelled_clips().empty()) {
      *named.mutable_labelled()->mutable_clips() = source.labelled_clips();
    }
    licences.insert(source.data_licences().begin(),
                    source.data_licences().end());
    // Runs of older versions know a teacher elsewhere by its digest alone.
    if (source.data_licences().empty()) licences.insert(kUnknown);
  }
  for (const std::string& licence : licences) {
    provenance.add_data_licences(licence);
  }
  const ClipUses uses = ClipUsesOfRun(inputs.recipe.task().start(),
                                      inputs.library, inputs.sources);
  for (const std::string& clip : provenance.clips()) {
    const v1::ClipUse use = uses.at(std::string(ClipNameOf(clip)));
    // Of the same name as a clip of its own, but from elsewhere.
    const bool others = use == v1::CLIP_USE_TRAINED_ON && !own.contains(clip);
    provenance.add_clip_uses(others ? v1::CLIP_USE_SOURCE_TRAINED_ON : use);
  }
}

void AddProvenance(const ContentInputs& inputs, v1::BundleManifest& manifest) {
  v1::BundleProvenance& provenance = *manifest.mutable_provenance();
  provenance.set_recipe(inputs.recipe.name());
  provenance.set_recipe_sha256(Sha256Hex(PrintRecipe(inputs.recipe)));
  provenance.set_library_sha256(inputs.library_sha256);
  AddData(inputs, provenance);
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
  SINEW_ASSIGN_OR_RETURN(
      const TensorMap weights,
      ParseSafetensors(snapshot.weights(), "weights of the snapshot"));
  content.graph = policy::GraphsWithout(snapshot.graph(), {"teacher"});
  content.weights = policy::WeightsOf(content.graph, weights);
  content.character_files = inputs.character_files;
  v1::BundleManifest& manifest = content.manifest;
  manifest.set_character(inputs.character->name());
  manifest.set_character_sha256(inputs.character->digest());
  AddJoints(*inputs.character, manifest);
  AddBodies(*inputs.character, manifest);
  SINEW_RETURN_IF_ERROR(AddTask(inputs, content.graph, manifest));
  AddProvenance(inputs, manifest);
  return content;
}

}  // namespace sinew::bundle
