#ifndef SINEW_SIM_WORLD_FOOT_CONTACT_H_
#define SINEW_SIM_WORLD_FOOT_CONTACT_H_

#include <mujoco/mujoco.h>

#include "absl/types/span.h"
#include "sim/character/character.h"

namespace sinew::world {

// Distance at which a sole counts as touching the floor, m.
inline constexpr double kContactDistance = 0.005;

// Writes [F] 1 where a foot's sole is within kContactDistance of the floor in
// the position qpos, 0 elsewhere. Places data's bodies and geoms
// (mj_kinematics) and uses its scratch memory; no state changes.
//
// Thread-safety: one caller per data. Blocking: never; nothing allocates.
// Errors: none.
void ReadFootContacts(const character::Character& character, mjData* data,
                      absl::Span<float> out);

}  // namespace sinew::world

#endif  // SINEW_SIM_WORLD_FOOT_CONTACT_H_
