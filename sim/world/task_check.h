#ifndef SINEW_SIM_WORLD_TASK_CHECK_H_
#define SINEW_SIM_WORLD_TASK_CHECK_H_

#include "absl/status/status.h"
#include "proto/sinew/v1/recipe.pb.h"
#include "sim/character/character.h"
#include "sim/motion/library.h"

namespace sinew::world {

// Whether recipe, character and library fit each other: physics rate a
// multiple of the control rate, compiled time step, library rate equal to the
// control rate, library fitted to this very character (digest), names of
// joints, bodies and feet in order, no clip shorter than the window of
// reference frames that the observation shows (a looping one goes on for ever).
// INVALID_ARGUMENT names the field, what was expected and what was found. Pure;
// never blocks.
absl::Status CheckTask(const v1::Recipe& recipe,
                       const character::Character& character,
                       const motion::Library& library);

}  // namespace sinew::world

#endif  // SINEW_SIM_WORLD_TASK_CHECK_H_
