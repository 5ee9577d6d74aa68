#ifndef SINEW_SIM_CHARACTER_SCENERY_H_
#define SINEW_SIM_CHARACTER_SCENERY_H_

#include <mujoco/mujoco.h>

namespace sinew::character {

// Gives a model what pictures need: a checkered material for its floor (the
// first plane of the world, which must exist), a pale sky and, instead of its
// own lights, one lamp from above. Physics is not changed.
void AddScenery(mjSpec* spec);

}  // namespace sinew::character

#endif  // SINEW_SIM_CHARACTER_SCENERY_H_
