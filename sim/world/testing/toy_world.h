#ifndef SINEW_SIM_WORLD_TESTING_TOY_WORLD_H_
#define SINEW_SIM_WORLD_TESTING_TOY_WORLD_H_

#include <initializer_list>
#include <memory>
#include <string>

#include "proto/sinew/v1/recipe.pb.h"
#include "sim/character/character.h"
#include "sim/motion/library.h"

namespace sinew::world::testing {

// A table that walks a little: a trunk on four legs, one hinge each; 5 bodies,
// 4 joints, 2 feet (the front legs). It stands by itself, so that episodes
// last, and its model, library and recipe are real ones, made by the code that
// makes them for people.
//
// Clips, at 30 Hz, velocities by MuJoCo from the joints' derivatives:
//   0 "turn"   24 frames, loops: trunk and legs swing, the trunk goes ahead
//              0.4 m and turns by 0.5 rad per period
//   1 "sway"   20 frames, does not loop: standing, legs swing a little
//   2 "tumble" 16 frames, does not loop: airborne, rolling over (no physics
//              could follow it)
//
// With a get-up, the trunk of "sway" rises from 0.3 m to 0.45 m, its first 7
// frames lower than upright (get_up_frames.h).
struct ToyWorld {
  // Holds character.textproto, its MJCF, and library/.
  std::string folder;
  v1::Recipe recipe;  // defaults filled
  std::unique_ptr<const character::Character> character;
  std::unique_ptr<const motion::Library> library;
  std::string library_folder;
};

// A recipe with all defaults.
v1::Recipe ToyRecipe();

enum class ToyClips { kStanding, kWithGetUp };

// Files go into a new folder below the test's temporary folder. Aborts with a
// message on any error.
ToyWorld MakeToyWorld(const v1::Recipe& recipe = ToyRecipe(),
                      ToyClips clips = ToyClips::kStanding);

// Leaves these clips of its library out of training; in memory, the folder
// stays as it is. Aborts with a message on any error.
void LeaveOut(std::initializer_list<int> clips, ToyWorld& world);

// Leaves one out in the library of a folder: another library of the same clips.
// Aborts with a message on any error, also where there is no such clip.
void LeaveOutOnDisk(int clip, const std::string& library_folder);

}  // namespace sinew::world::testing

#endif  // SINEW_SIM_WORLD_TESTING_TOY_WORLD_H_
