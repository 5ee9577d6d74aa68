#ifndef SINEW_SIM_CHARACTER_COMPILE_H_
#define SINEW_SIM_CHARACTER_COMPILE_H_

#include <string>

#include "absl/status/statusor.h"
#include "proto/sinew/v1/character.pb.h"
#include "proto/sinew/v1/recipe.pb.h"
#include "sim/character/model_ptr.h"

namespace sinew::character {

// What a compiled model is for: stepping, without anything that physics does
// not need (visual geoms and their meshes), or pictures, with all of it, a
// patterned floor, a sky and a lamp. Both have the same bodies, joints and
// qpos.
enum class Purpose { kPhysics, kPictures };

// Compiles the MJCF at `path` as a body to be simulated:
//   - actuators, sensors, keyframes, cameras, lights and explicit contact pairs
//     are removed;
//   - the hinges of `character` get its damping (MuJoCo's Euler integrator
//     treats it implicitly) and, where set, its armature;
//   - its contactless_geoms touch nothing;
//   - other geoms of the body touch geoms of the world only; under
//     self_collision also each other, without friction, except parent and child
//     and the pairs of bodies that overlap at rest or in the default pose;
//   - the first plane of the world is the floor; without one, a plane "floor"
//     at z = 0 is added. The floor's friction and contact dimension (3) count
//     for both geoms of a contact;
//   - options: step 1 / physics_hz, Euler, Newton, pyramidal cone, the
//     recipe's iterations and tolerance, no islands.
// Unset physics fields mean the defaults of recipe.proto.
//
// Thread-safety: any thread. Blocking: reads the MJCF and its meshes. Errors:
// INVALID_ARGUMENT naming `path` and MuJoCo's message, the joint that is not a
// hinge of the model, the contactless geom that it lacks, that touches
// nothing as it is, is the world's or listed twice, or the physics field that
// is out of range.
absl::StatusOr<ModelPtr> CompileModel(const std::string& path,
                                      const v1::Character& character,
                                      const v1::Physics& physics,
                                      Purpose purpose);

}  // namespace sinew::character

#endif  // SINEW_SIM_CHARACTER_COMPILE_H_
