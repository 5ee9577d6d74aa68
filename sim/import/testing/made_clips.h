#ifndef SINEW_SIM_IMPORT_TESTING_MADE_CLIPS_H_
#define SINEW_SIM_IMPORT_TESTING_MADE_CLIPS_H_

#include <string>
#include <vector>

namespace sinew::import::testing {

// Clips in the DeepMimic format, made by formula: what tests import where no
// recorded clip lies about.

// A march along x, 1 s, looping, 0.8 m a cycle: legs swing and lift in turn,
// arms and trunk along. Its feet float by `floating` metres.
std::string MarchJson(double floating = 0);

// Lies on its back for 1 s, half a metre above the floor.
std::string LyingJson();

// A few recorded DeepMimic clips (walk, run, jump) below the folder that
// the environment variable SINEW_DATA names; empty if it is unset.
std::vector<std::string> RecordedClips();

}  // namespace sinew::import::testing

#endif  // SINEW_SIM_IMPORT_TESTING_MADE_CLIPS_H_
