#ifndef SINEW_SIM_IMPORT_TESTING_AMC_PLAY_H_
#define SINEW_SIM_IMPORT_TESTING_AMC_PLAY_H_

#include <map>
#include <string>
#include <vector>

#include "sim/character/character.h"
#include "sim/import/retarget/model_motion.h"

namespace sinew::import::testing {

// Plays AMC files on the character cmu_humanoid without any retargeting: its
// joints are named after the bones and angles of the files (bone + "r" + axis)
// and turn in the same order about the same axes, so that
//
//   qpos[lfemurrx] = the first angle of "lfemur", in radians.
//
// The root's numbers are turned from the files' y up to z up: x to y, y to z,
// z to x. What an importer makes of the same file can be held against it.
//
// Thread-safety: pure. Blocking: ReadAmc on the disk. Errors: abort with a
// message.

// Numbers of one frame by bone, as they stand in the file (degrees).
using AmcFrame = std::map<std::string, std::vector<double>>;

std::vector<AmcFrame> ReadAmc(const std::string& path);

// `metres_per_unit`: of the root's place, here of the character's size.
ModelMotion PlayAmc(const character::Character& cmu_humanoid,
                    const std::vector<AmcFrame>& frames,
                    double metres_per_unit);

}  // namespace sinew::import::testing

#endif  // SINEW_SIM_IMPORT_TESTING_AMC_PLAY_H_
