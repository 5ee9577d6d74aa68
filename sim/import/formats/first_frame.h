#ifndef SINEW_SIM_IMPORT_FORMATS_FIRST_FRAME_H_
#define SINEW_SIM_IMPORT_FORMATS_FIRST_FRAME_H_

#include "sim/import/formats/source_clip.h"

namespace sinew::import {

// Some writers (CMU's BVH for MotionBuilder) put a pose of reference, most
// joints unturned, before the motion. It is no part of it.
//
// Thread-safety: pure functions. Blocking: never. Errors: none.

// True if the first pose leaves at least half of the joints unturned (1 degree)
// and the second one is a jump away from it: on the mean over joints further
// than 5 degrees and than five times the median of the next steps. False for
// clips of less than four poses.
bool FirstFrameIsRest(const SourceClip& clip);

// Removes the first of at least three poses; the next one is at time 0.
void DropFirstPose(SourceClip& clip);

}  // namespace sinew::import

#endif  // SINEW_SIM_IMPORT_FORMATS_FIRST_FRAME_H_
