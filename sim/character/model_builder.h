#ifndef SINEW_SIM_CHARACTER_MODEL_BUILDER_H_
#define SINEW_SIM_CHARACTER_MODEL_BUILDER_H_

#include <string>

#include "absl/status/statusor.h"
#include "proto/sinew/v1/character.pb.h"
#include "proto/sinew/v1/recipe.pb.h"
#include "sim/character/model_ptr.h"

namespace sinew::character {

// Compiles an MJCF file for simulation:
//  - timestep 1 / physics_hz, Euler, Newton with the recipe's iterations and
//    tolerance, islands off;
//  - a floor plane where the file has none; other geoms of the world stay;
//  - contacts with the floor only, or, with self_collision, between bodies of
//    the character too (not parent and child, not pairs that already touch in
//    the default pose); condim 3, the recipe's friction;
//  - actuators, sensors and keyframes removed;
//  - joint damping set to the character's gains, which Euler treats implicitly.
// INVALID_ARGUMENT with MuJoCo's message if it does not compile.
absl::StatusOr<ModelPtr> BuildModel(const std::string& mjcf_path,
                                    const v1::Character& character,
                                    const v1::Physics& physics);

}  // namespace sinew::character

#endif  // SINEW_SIM_CHARACTER_MODEL_BUILDER_H_
