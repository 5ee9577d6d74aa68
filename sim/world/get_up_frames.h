#ifndef SINEW_SIM_WORLD_GET_UP_FRAMES_H_
#define SINEW_SIM_WORLD_GET_UP_FRAMES_H_

#include <vector>

#include "proto/sinew/v1/recipe.pb.h"
#include "sim/character/character.h"
#include "sim/motion/library.h"
#include "sim/world/start.h"

namespace sinew::world {

// Share of the standing root height below which a body lies, kneels or
// crouches, and at or above which it is upright.
inline constexpr double kUprightShare = 0.8;

// Height of the root, m, at or above which a character is upright.
double UprightRootHeight(const character::Character& character);

// Share of the standing root height by which the root has risen from where a
// get-up began once the body has left the floor.
inline constexpr double kRiseShare = 0.2;

// The frames of a library at which a body at rest on the floor can begin to get
// up: those of its get-ups from the first one on until the root has risen by
// `rise_share` (>= 0) of its standing height or is upright, in the order of
// clip and frame. Later ones may show a body that lies, but live by its
// momentum. A get-up is a clip that IsDrawn (start.h) by `recipe`, does not
// loop, begins lower than upright and ends upright.
//
// Pure function; reads these frames of the get-ups once. Errors: none.
std::vector<StartFrame> GetUpFrames(const v1::Start& recipe,
                                    const character::Character& character,
                                    const motion::Library& library,
                                    double rise_share = kRiseShare);

// For how long a body that has got up can go on at least, s, before its clip
// ends or leads down again.
inline constexpr double kSecondsUp = 1;

// The frames at which a body that has got up, or whose clip has ended, may go
// on: those of the clips that IsDrawn in which the character is upright, there
// and in the frames of the `seconds` (>= 0) after it (of a looping clip, as it
// comes round), in the order of clip and frame.
//
// Pure function; reads every frame once or, of a looping clip, some twice.
// Errors: none.
std::vector<StartFrame> UprightFrames(const v1::Start& recipe,
                                      const character::Character& character,
                                      const motion::Library& library,
                                      double seconds = kSecondsUp);

}  // namespace sinew::world

#endif  // SINEW_SIM_WORLD_GET_UP_FRAMES_H_
