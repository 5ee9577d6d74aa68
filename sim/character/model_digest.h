#ifndef SINEW_SIM_CHARACTER_MODEL_DIGEST_H_
#define SINEW_SIM_CHARACTER_MODEL_DIGEST_H_

#include <mujoco/mujoco.h>

#include <string>

#include "proto/sinew/v1/character.pb.h"

namespace sinew::character {

// SHA-256 (hex) over a character's text proto and what of its compiled model a
// motion depends on: names, poses and inertias of bodies; types, anchors, axes,
// ranges and armature of joints; shapes and poses of colliding geoms. Left out
// is what physics settings change (options, damping, contact filters) and the
// version of MuJoCo.
//
// Thread-safety: pure. Blocking: never. Errors: none.
std::string ModelDigest(const v1::Character& character, const mjModel& model);

}  // namespace sinew::character

#endif  // SINEW_SIM_CHARACTER_MODEL_DIGEST_H_
