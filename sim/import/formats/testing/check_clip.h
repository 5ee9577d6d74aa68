#ifndef SINEW_SIM_IMPORT_FORMATS_TESTING_CHECK_CLIP_H_
#define SINEW_SIM_IMPORT_FORMATS_TESTING_CHECK_CLIP_H_

#include "sim/import/formats/source_clip.h"

namespace sinew::import::testing {

// Aborts unless a clip is all that source_clip.h promises: at least two poses
// with times rising from 0 to at most kMaxClipSeconds, parents before children,
// different names, a root without offset, finite numbers, unit quaternions.
// What a fuzzer asks of every clip that a reader gives.
void CheckClip(const SourceClip& clip);
void CheckClip(const RobotClip& clip);

}  // namespace sinew::import::testing

#endif  // SINEW_SIM_IMPORT_FORMATS_TESTING_CHECK_CLIP_H_
