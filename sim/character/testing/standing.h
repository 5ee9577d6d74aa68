#ifndef SINEW_SIM_CHARACTER_TESTING_STANDING_H_
#define SINEW_SIM_CHARACTER_TESTING_STANDING_H_

#include <mujoco/mujoco.h>

#include "sim/character/character.h"
#include "sim/character/gains.h"

namespace sinew::character::testing {

// Sets the default pose at the standing height.
void Stand(const Character& character, mjData* data);

// One physics step under the torque law of the design, written out anew:
// clamp(kp (q* - q) - kd dq) + kd dq, the damping itself being the model's.
void StepTowardsDefault(const Character& character, mjData* data);

// Height of the lowest point of the soles (spheres, capsules and boxes) in the
// pose of `data`, whose kinematics are computed.
double LowestSole(const Character& character, mjData* data);

// Holds every joint's gains against the rule; they are written with four
// digits.
void ExpectGains(const Character& character, const GainRule& rule);

// Metres by which a mirrored body may miss its partner.
struct MirrorTolerance {
  double frames = 0;   // origins of body frames
  double centres = 0;  // centres of mass
};

// Holds the mirror pairs against the model: in random poses every body is
// where the mirrored pose has its partner, itself if it has none.
void ExpectMirrorImage(const Character& character,
                       const MirrorTolerance& tolerance);

}  // namespace sinew::character::testing

#endif  // SINEW_SIM_CHARACTER_TESTING_STANDING_H_
