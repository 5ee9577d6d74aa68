#include "sim/world/task_check.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "common/config/recipe.h"
#include "common/status_macros.h"

namespace sinew::world {
namespace {

using Names = google::protobuf::RepeatedPtrField<std::string>;

absl::Status CheckRates(const v1::Physics& physics, const mjModel* model,
                        const v1::MotionLibrary& library) {
  const double ratio = physics.physics_hz() / physics.control_hz();
  if (!(ratio >= 1) || std::abs(ratio - std::round(ratio)) > 1e-9) {
    return absl::InvalidArgumentError(absl::StrFormat(
        "recipe field physics.physics_hz: expected a multiple of control_hz "
        "%g, found %g",
        physics.control_hz(), physics.physics_hz()));
  }
  if (std::abs(model->opt.timestep * physics.physics_hz() - 1) > 1e-9) {
    return absl::InvalidArgumentError(absl::StrFormat(
        "character model: expected time step %g s (physics.physics_hz %g), "
        "found %g s",
        1 / physics.physics_hz(), physics.physics_hz(), model->opt.timestep));
  }
  if (std::abs(library.frames_per_second() - physics.control_hz()) > 1e-9) {
    return absl::InvalidArgumentError(
        absl::StrFormat("motion library field frames_per_second: expected %g "
                        "(physics.control_hz), found %g",
                        physics.control_hz(), library.frames_per_second()));
  }
  return absl::OkStatus();
}

absl::Status CheckNames(const char* field,
                        const std::vector<std::string>& expected,
                        const Names& found) {
  if (static_cast<int>(expected.size()) != found.size()) {
    return absl::InvalidArgumentError(
        absl::StrCat("motion library field ", field, ": expected ",
                     expected.size(), " names, found ", found.size()));
  }
  for (int i = 0; i < found.size(); ++i) {
    if (expected[i] != found[i]) {
      return absl::InvalidArgumentError(
          absl::StrCat("motion library field ", field, "[", i, "]: expected \"",
                       expected[i], "\", found \"", found[i], "\""));
    }
  }
  return absl::OkStatus();
}

// From the current frame to the farthest one ahead.
absl::Status CheckWindow(const v1::Observation& observation,
                         const v1::MotionLibrary& library) {
  const auto& blocks = observation.blocks();
  if (!blocks.empty() &&
      std::all_of(blocks.begin(), blocks.end(), IsSelfBlock)) {
    return absl::OkStatus();
  }
  int32_t ahead = 1;
  for (const int32_t frames : observation.frames_ahead()) {
    ahead = std::max(ahead, frames);
  }
  for (const v1::ClipInfo& clip : library.clips()) {
    if (clip.loops() || clip.num_frames() > ahead) continue;
    return absl::InvalidArgumentError(absl::StrCat(
        "motion library clip \"", clip.name(), "\": expected at least ",
        int64_t{ahead} + 1,
        " frames, the window of task.observation.frames_ahead, found ",
        clip.num_frames(), "; import the library without it"));
  }
  return absl::OkStatus();
}

std::string BodyName(const mjModel* model, int body) {
  const char* name = mj_id2name(model, mjOBJ_BODY, body);
  return name == nullptr ? "" : name;
}

}  // namespace

absl::Status CheckTask(const v1::Recipe& recipe,
                       const character::Character& character,
                       const motion::Library& library) {
  const mjModel* model = character.model();
  const v1::MotionLibrary& manifest = library.manifest();
  if (manifest.character_sha256() != character.digest()) {
    return absl::InvalidArgumentError(absl::StrCat(
        "motion library field character_sha256: expected ", character.digest(),
        " (character ", character.name(), "), found ",
        manifest.character_sha256(), " (character ", manifest.character(),
        "); import the clips again for this character"));
  }
  SINEW_RETURN_IF_ERROR(CheckRates(recipe.physics(), model, manifest));
  std::vector<std::string> joints, bodies, feet;
  for (const auto& joint : character.joints()) joints.push_back(joint.name);
  for (int id = 1; id < model->nbody; ++id) {
    bodies.push_back(BodyName(model, id));
  }
  for (int id : character.foot_bodies()) feet.push_back(BodyName(model, id));
  SINEW_RETURN_IF_ERROR(CheckNames("joints", joints, manifest.joints()));
  SINEW_RETURN_IF_ERROR(CheckNames("bodies", bodies, manifest.bodies()));
  SINEW_RETURN_IF_ERROR(CheckNames("feet", feet, manifest.feet()));
  return CheckWindow(recipe.task().observation(), manifest);
}

}  // namespace sinew::world
