#ifndef SINEW_SIM_CHARACTER_MODEL_DIGEST_H_
#define SINEW_SIM_CHARACTER_MODEL_DIGEST_H_

#include <mujoco/mujoco.h>

#include <string>

#include "absl/strings/string_view.h"

namespace sinew::character {

// SHA-256 (hex) of what makes the body: names, tree, frames, inertias, joint
// axes and ranges, geom shapes (the floor left out), and the text proto. The
// same for every rate, solver setting and contact filter. Pure.
std::string BodyDigest(const mjModel& model, int floor_geom,
                       absl::string_view character_text);

}  // namespace sinew::character

#endif  // SINEW_SIM_CHARACTER_MODEL_DIGEST_H_
