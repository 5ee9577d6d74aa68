#ifndef SINEW_SIM_MOTION_CLIP_DIGEST_H_
#define SINEW_SIM_MOTION_CLIP_DIGEST_H_

#include <string>
#include <vector>

#include "sim/motion/library.h"

namespace sinew::motion {

// SHA-256 (hex) of what an episode can see of each clip: rate, frames, whether
// and how it repeats. Names, figures, licences, the place in the library and
// the side of the split are not in it, so a clip that is imported again, alone
// or with others, keeps its digest. Reads every frame; clips of different
// characters never agree, but for equal numbers. Pure.
std::vector<std::string> ClipDigests(const Library& library);

}  // namespace sinew::motion

#endif  // SINEW_SIM_MOTION_CLIP_DIGEST_H_
