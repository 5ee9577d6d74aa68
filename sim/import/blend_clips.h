#ifndef SINEW_SIM_IMPORT_BLEND_CLIPS_H_
#define SINEW_SIM_IMPORT_BLEND_CLIPS_H_

#include <limits>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "common/stop.h"
#include "sim/import/retarget/dynamics.h"
#include "sim/import/retarget/retarget.h"

namespace sinew::import {

// Frames that are kept of a motion, as in Trim (edit.h).
struct KeptSeconds {
  double from_s = 0;
  double to_s = std::numeric_limits<double>::infinity();
};

// How one clip leads over to another.
struct BlendOptions {
  // Seconds from the last frame of the first to the first of the second; range
  // and rounding: CheckBlendGap and BlendSteps (edit.h).
  double gap_s = 0.5;
  // What of each is used.
  KeptSeconds first = {}, second = {};
};

// INVALID_ARGUMENT naming what is out of range. Pure.
absl::Status CheckBlendOptions(const BlendOptions& options);

// Two clips on one character, joined over a gap into one: Trim of each, Blend
// (edit.h), and then what every clip goes through: floor under the whole,
// changed to what forces explain, forces and figures. Both parts keep their
// motion but for what these steps change of them, most of it near the gap.
//
// Figures that hold the motion against its source are those of both clips,
// whole: means by frames, maxima the larger. The source's skeleton is unknown
// in the gap, so none is shown. Map and warnings are the first's, with the
// second's warnings behind. The result does not loop.
//
// Thread-safety: as Dynamics. Ownership: borrows its arguments for the call.
// Blocking: seconds of computation. Errors: CheckBlendOptions, Trim and Blend.
absl::StatusOr<Retargeted> BlendClips(const BlendOptions& options,
                                      const Retargeted& first,
                                      const Retargeted& second,
                                      Dynamics* dynamics,
                                      const StopToken& stop = {});

}  // namespace sinew::import

#endif  // SINEW_SIM_IMPORT_BLEND_CLIPS_H_
