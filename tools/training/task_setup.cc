#include "tools/training/task_setup.h"

#include <map>
#include <memory>
#include <utility>

#include "absl/strings/str_cat.h"
#include "actor/rollout_assets.h"
#include "common/config/recipe.h"
#include "common/digest.h"
#include "common/files.h"
#include "common/mapped_file.h"
#include "common/status_context.h"
#include "common/status_macros.h"
#include "learner/curriculum/only_clips_check.h"
#include "sim/character/character.h"
#include "sim/motion/clip_digest.h"
#include "sim/motion/library.h"
#include "sim/world/fallen_states.h"
#include "sim/world/mirror.h"
#include "sim/world/start.h"
#include "tools/training/student_reach.h"

namespace sinew::tools {
namespace {

constexpr char kFramesFile[] = "frames.safetensors";

using Assets = std::map<std::string, std::string>;

// Whether these are the bytes of `count` fallen states of a character.
bool AreFallenStates(const Blob& bytes, const character::Character& character,
                     int count) {
  if (bytes == nullptr) return false;
  const auto states = world::FallenStates::Parse(*bytes, character, "kept");
  return states.ok() && states->size() == count;
}

// The asset "fallen", beside those that are there.
absl::Status AddFallenStates(const v1::Recipe& recipe,
                             const character::Character& character,
                             const KeptFallenStates& kept, Assets* assets) {
  const v1::Recovery& recovery = recipe.task().recovery();
  if (!(FallenShare(recovery) > 0)) return absl::OkStatus();
  const Blob before = kept ? kept(*assets) : nullptr;
  if (AreFallenStates(before, character, recovery.fallen_states())) {
    (*assets)["fallen"] = *before;
    return absl::OkStatus();
  }
  SINEW_ASSIGN_OR_RETURN(const auto made,
                         world::FallenStates::MakeFor(character, recipe));
  (*assets)["fallen"] = made->Serialize();
  return absl::OkStatus();
}

// The assets' bytes by role, as in TaskAssets; `frames` is the file that those
// of its role are a copy of.
absl::StatusOr<Assets> MakeAssets(const v1::Recipe& recipe,
                                  const std::string& character_name,
                                  const std::string& motions,
                                  const KeptFallenStates& kept,
                                  std::shared_ptr<const MappedFile>* frames) {
  SINEW_ASSIGN_OR_RETURN(
      const std::unique_ptr<character::Character> character,
      character::Character::Load(character_name, recipe.physics()));
  Assets assets;
  assets["character"] = character->character_text();
  assets["model"] = character->model_binary();
  assets["recipe"] = PrintRecipe(recipe);
  SINEW_ASSIGN_OR_RETURN(assets["library"],
                         ReadFile(JoinPath(motions, "manifest.json")));
  SINEW_ASSIGN_OR_RETURN(*frames,
                         MappedFile::Open(JoinPath(motions, kFramesFile)));
  assets["frames"] = std::string((*frames)->bytes());
  SINEW_RETURN_IF_ERROR(AddFallenStates(recipe, *character, kept, &assets));
  return assets;
}

// The bytes of a role, empty where there is none.
absl::string_view Optional(const Assets& assets, const std::string& role) {
  const auto found = assets.find(role);
  return found == assets.end() ? absl::string_view() : found->second;
}

// Before a run's folder is touched.
absl::Status CheckTrainedOn(const v1::Start& start,
                            const motion::Library& library,
                            const std::string& motions) {
  SINEW_RETURN_IF_ERROR(learner::CheckOnlyClips(start, library.manifest()));
  for (const v1::ClipInfo& clip : library.manifest().clips()) {
    if (world::IsDrawn(start, clip)) return absl::OkStatus();
  }
  return absl::InvalidArgumentError(
      absl::StrCat(motions, ": expected clips to train on, found none among ",
                   library.num_clips(), " that is not left out of training"));
}

// That bodies that are to go on have where to.
absl::Status CheckGoesOn(const actor::RolloutAssets& rollout,
                         const std::string& motions) {
  const v1::Recipe& recipe = rollout.recipe();
  const v1::Start& start = recipe.task().start();
  if (start.carry_on_share() > 0 && rollout.onward_frames().size() == 0) {
    return absl::InvalidArgumentError(absl::StrCat(
        motions, ": expected a clip that stays up for ",
        start.carry_on_seconds(),
        " s (recipe field task.start.carry_on_seconds), found none"));
  }
  const v1::Distillation& distillation = recipe.distillation();
  if (distillation.prior_share() > 0 && rollout.nearest_frames().size() == 0) {
    return absl::InvalidArgumentError(absl::StrCat(
        motions, ": expected a clip that goes on for ",
        distillation.prior_seconds_ahead(),
        " s (recipe field distillation.prior_seconds_ahead), found none"));
  }
  return absl::OkStatus();
}

v1::TaskAssets ListAssets(const std::map<std::string, Blob>& assets) {
  v1::TaskAssets list;
  for (const auto& [role, bytes] : assets) {
    v1::Asset& asset = *list.add_assets();
    asset.set_role(role);
    asset.set_sha256(Sha256Hex(*bytes));
    asset.set_size(static_cast<int64_t>(bytes->size()));
  }
  return list;
}

}  // namespace

absl::StatusOr<TaskSetup> SetUpTask(const v1::Recipe& recipe,
                                    const std::string& character,
                                    const std::string& motions,
                                    const KeptFallenStates& kept) {
  // This process uses the file; actors get a copy of it.
  std::shared_ptr<const MappedFile> frames;
  SINEW_ASSIGN_OR_RETURN(auto assets,
                         MakeAssets(recipe, character, motions, kept, &frames));
  TaskSetup setup;
  SINEW_ASSIGN_OR_RETURN(
      setup.library,
      motion::Library::FromMapped(assets["library"], frames, motions));
  SINEW_RETURN_IF_ERROR(
      CheckTrainedOn(recipe.task().start(), *setup.library, motions));
  setup.clip_sha256 = motion::ClipDigests(*setup.library);
  SINEW_ASSIGN_OR_RETURN(
      const auto rollout,
      actor::RolloutAssets::Create(assets["character"], assets["model"],
                                   assets["library"], frames, assets["recipe"],
                                   Optional(assets, "fallen")));
  if (recipe.task().recovery().get_up_share() > 0 &&
      rollout->task().num_get_up_frames() == 0) {
    return absl::InvalidArgumentError(absl::StrCat(
        motions,
        ": expected a clip that begins on the floor and ends upright, since "
        "recipe field task.recovery.get_up_share is not 0, found none"));
  }
  SINEW_RETURN_IF_ERROR(CheckGoesOn(*rollout, motions));
  const character::Character& body = rollout->task().character();
  setup.character = body.name();
  setup.character_sha256 = body.digest();
  SINEW_RETURN_IF_ERROR(CheckReach(recipe, body.joints()));
  for (const character::JointInfo& joint : body.joints()) {
    setup.joints.push_back(joint.name);
  }
  setup.observation = std::make_shared<const world::ObservationBuilder>(
      rollout->task().observation());
  setup.observation_width = rollout->task().observation_width();
  setup.self_observation_width = rollout->task().self_observation_width();
  setup.action_width = rollout->task().action_width();
  setup.action_scales = rollout->task().action_law().Scales();
  setup.layout = rollout->layout();
  setup.layout_sha256 = rollout->layout_sha256();
  setup.limits = rollout->limits();
  if (recipe.ppo().mirror() || recipe.distillation().mirror()) {
    absl::StatusOr<SegmentMirror> mirror = world::MakeMirror(rollout->task());
    if (!mirror.ok()) {
      return WithContext(
          mirror.status(),
          absl::StrCat("recipe field ",
                       recipe.ppo().mirror() ? "ppo" : "distillation",
                       ".mirror"));
    }
    setup.mirror = *std::move(mirror);
  }
  for (auto& [role, bytes] : assets) {
    setup.assets[role] = std::make_shared<const std::string>(std::move(bytes));
  }
  setup.list = std::make_shared<const std::string>(
      SerializeDeterministically(ListAssets(setup.assets)));
  setup.assets_sha256 = Sha256Hex(*setup.list);
  return setup;
}

}  // namespace sinew::tools
