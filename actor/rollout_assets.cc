#include "actor/rollout_assets.h"

#include <utility>

#include "common/config/recipe.h"
#include "common/segment/segment_layout.h"
#include "common/status_macros.h"
#include "sim/world/get_up_frames.h"
#include "sim/world/start.h"

namespace sinew::actor {
namespace {

absl::StatusOr<std::unique_ptr<motion::Library>> LoadLibrary(
    absl::string_view manifest, const RolloutAssets::Frames& frames) {
  constexpr char kSource[] = "asset library";
  if (const auto* bytes = std::get_if<absl::string_view>(&frames)) {
    return motion::Library::FromBytes(manifest, *bytes, kSource);
  }
  return motion::Library::FromMapped(
      manifest, std::get<std::shared_ptr<const MappedFile>>(frames), kSource);
}

v1::StateLimits LimitsOf(const world::TrackingTask& task) {
  v1::StateLimits limits;
  for (const v1::ClipInfo& clip : task.library().manifest().clips()) {
    v1::StateLimits::Clip& limit = *limits.add_clips();
    limit.set_start_frames(static_cast<int32_t>(world::NumStartFrames(clip)));
    limit.set_loops(clip.loops());
  }
  limits.set_state_size(task.state_size());
  limits.set_joints(task.action_width());
  limits.set_max_episode_steps(task.recipe().task().max_episode_steps());
  limits.set_recovery_steps(task.recovery().on() ? task.recovery().most_steps()
                                                 : 0);
  return limits;
}

}  // namespace

absl::StatusOr<std::shared_ptr<const RolloutAssets>> RolloutAssets::Create(
    absl::string_view character_text, absl::string_view model_binary,
    absl::string_view library_manifest, const Frames& frames,
    absl::string_view recipe_text, absl::string_view fallen) {
  SINEW_ASSIGN_OR_RETURN(v1::Recipe parsed,
                         ParseRecipe(recipe_text, "asset recipe"));
  const v1::Recipe recipe = WithDefaults(std::move(parsed));
  SINEW_RETURN_IF_ERROR(ValidateRecipe(recipe));
  SINEW_ASSIGN_OR_RETURN(std::unique_ptr<character::Character> character,
                         character::Character::FromAssets(
                             character_text, model_binary, "asset character"));
  SINEW_ASSIGN_OR_RETURN(std::unique_ptr<motion::Library> library,
                         LoadLibrary(library_manifest, frames));
  std::unique_ptr<const world::FallenStates> fallen_states;
  if (!fallen.empty()) {
    SINEW_ASSIGN_OR_RETURN(
        world::FallenStates parsed_states,
        world::FallenStates::Parse(fallen, *character, "asset fallen"));
    fallen_states =
        std::make_unique<world::FallenStates>(std::move(parsed_states));
  }
  return FromParts(recipe, std::move(character), std::move(library),
                   std::move(fallen_states));
}

absl::StatusOr<std::shared_ptr<const RolloutAssets>> RolloutAssets::FromParts(
    const v1::Recipe& recipe,
    std::unique_ptr<const character::Character> character,
    std::unique_ptr<const motion::Library> library,
    std::unique_ptr<const world::FallenStates> fallen) {
  std::shared_ptr<RolloutAssets> assets(new RolloutAssets());
  assets->character_ = std::move(character);
  assets->library_ = std::move(library);
  assets->fallen_ = std::move(fallen);
  SINEW_ASSIGN_OR_RETURN(
      assets->task_,
      world::TrackingTask::Create(recipe, *assets->character_,
                                  *assets->library_, assets->fallen_.get()));
  assets->layout_ = MakeSegmentLayout(
      assets->task_->observation_width(), assets->task_->action_width(),
      recipe.has_distillation(), RecordedLatentWidth(recipe));
  assets->layout_sha256_ = LayoutSha256(assets->layout_);
  assets->limits_ = LimitsOf(*assets->task_);
  return assets;
}

const world::NearestFrames& RolloutAssets::nearest_frames() const {
  absl::call_once(nearest_once_, [this] {
    nearest_frames_ = std::make_unique<const world::NearestFrames>(
        recipe().task().start(), *library_, world::BodyReader(*character_),
        recipe().distillation().prior_seconds_ahead());
  });
  return *nearest_frames_;
}

const world::NearestFrames& RolloutAssets::upright_frames() const {
  absl::call_once(upright_once_,
                  [this] { upright_frames_ = StaysUpFor(world::kSecondsUp); });
  return *upright_frames_;
}

const world::NearestFrames& RolloutAssets::onward_frames() const {
  absl::call_once(onward_once_, [this] {
    onward_frames_ = StaysUpFor(recipe().task().start().carry_on_seconds());
  });
  return *onward_frames_;
}

std::unique_ptr<const world::NearestFrames> RolloutAssets::StaysUpFor(
    double seconds) const {
  return std::make_unique<const world::NearestFrames>(
      world::UprightFrames(recipe().task().start(), *character_, *library_,
                           seconds),
      *library_, world::BodyReader(*character_));
}

}  // namespace sinew::actor
