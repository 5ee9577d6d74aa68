#ifndef SINEW_SIM_IMPORT_FORMATS_READ_OPTIONS_H_
#define SINEW_SIM_IMPORT_FORMATS_READ_OPTIONS_H_

#include "absl/status/status.h"
#include "sim/import/formats/source_clip.h"

namespace sinew::import {

// Highest rate that a clip may have, frames per second.
inline constexpr double kMaxFramesPerSecond = 10000;

// INVALID_ARGUMENT naming the field, expected and found, unless every field
// that is set makes sense: metres_per_unit > 0 and at most 1e6, up_axis x, y or
// z, frames_per_second > 0 and at most kMaxFramesPerSecond, quaternion_order
// wxyz or xyzw.
absl::Status CheckReadOptions(const ReadOptions& options);

}  // namespace sinew::import

#endif  // SINEW_SIM_IMPORT_FORMATS_READ_OPTIONS_H_
