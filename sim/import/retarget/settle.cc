#include "sim/import/retarget/settle.h"

#include <cmath>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "common/status_macros.h"
#include "sim/import/retarget/ground.h"
#include "sim/import/retarget/refine.h"

namespace sinew::import {

absl::Status CheckOptions(const RetargetOptions& options) {
  if (options.rate > 0 && options.rate <= 1000) return absl::OkStatus();
  return absl::InvalidArgumentError(absl::StrCat(
      "rate: expected > 0 and at most 1000 frames per second, found ",
      options.rate));
}

absl::Status CheckModel(const ImportModel& model) {
  if (model.model->njnt == 0 || model.model->jnt_type[0] != mjJNT_FREE) {
    return absl::InvalidArgumentError(
        "character: expected a free joint on its first body, found none");
  }
  if (!model.feet.empty()) return absl::OkStatus();
  return absl::InvalidArgumentError(
      "character: expected feet to stand on, found none");
}

absl::Status CheckFrames(const std::string& name, double seconds,
                         const RetargetOptions& options) {
  const double frames = std::round(seconds * options.rate);
  if (frames <= kMaxFrames) return absl::OkStatus();
  return absl::ResourceExhaustedError(absl::StrFormat(
      "%s: expected at most %d frames, found %.0f: %g s at %g frames per "
      "second",
      name, kMaxFrames, frames, seconds, options.rate));
}

absl::Status CheckStop(const RetargetOptions& options) {
  if (!options.stop.stop_requested()) return absl::OkStatus();
  return absl::CancelledError("retargeting was stopped");
}

absl::Status Settle(const RetargetOptions& options,
                    const std::vector<bool>& supported, Dynamics* dynamics,
                    Retargeted* result) {
  ModelMotion& motion = result->motion;
  if (options.refine) {
    RefineOptions refine;
    refine.stop = options.stop;
    motion =
        RefineMotion(dynamics, FindBearingPoints(dynamics, supported, motion),
                     motion, refine);
  }
  SINEW_RETURN_IF_ERROR(CheckStop(options));
  result->frames = AnalyseMotion(dynamics, motion);
  double carried = 0;
  for (const bool flag : supported) carried += flag;
  result->supported_share = carried / motion.frames();
  result->quality = MeasureQuality(dynamics, motion, result->frames);
  return CheckStop(options);
}

}  // namespace sinew::import
