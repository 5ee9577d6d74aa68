#ifndef SINEW_SIM_IMPORT_RETARGET_SETTLE_H_
#define SINEW_SIM_IMPORT_RETARGET_SETTLE_H_

#include <string>
#include <vector>

#include "absl/status/status.h"
#include "sim/import/retarget/dynamics.h"
#include "sim/import/retarget/retarget.h"

namespace sinew::import {

// The last steps of every clip: from joint angles to a motion on the floor with
// forces and figures.

// INVALID_ARGUMENT if the rate is out of range.
absl::Status CheckOptions(const RetargetOptions& options);

// INVALID_ARGUMENT if the character's first joint is not free or it has no
// feet.
absl::Status CheckModel(const ImportModel& model);

// RESOURCE_EXHAUSTED if a clip of so many seconds has more than kMaxFrames.
absl::Status CheckFrames(const std::string& name, double seconds,
                         const RetargetOptions& options);

// CANCELLED once it is to stop.
absl::Status CheckStop(const RetargetOptions& options);

// Fills frames, quality (less the figures of the fit) and supported_share of a
// result whose motion stands on the floor already; refines it before, if asked
// to. `supported` from FindSupport. CANCELLED as CheckStop.
absl::Status Settle(const RetargetOptions& options,
                    const std::vector<bool>& supported, Dynamics* dynamics,
                    Retargeted* result);

}  // namespace sinew::import

#endif  // SINEW_SIM_IMPORT_RETARGET_SETTLE_H_
