#include "sim/import/retarget/retarget.h"

#include <cmath>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "common/status_macros.h"
#include "sim/import/retarget/dynamics.h"
#include "sim/import/retarget/ground.h"
#include "sim/import/retarget/settle.h"
#include "sim/import/retarget/body_map.h"
#include "sim/import/retarget/source_track.h"

namespace sinew::import {
namespace {

// Drift of a source quaternion's norm that is worth a word.
constexpr double kDriftWarning = 0.01;

void Warn(const SourceClip& clip, const BodyMap& map,
          std::vector<std::string>* warnings) {
  if (clip.quaternion_drift > kDriftWarning) {
    warnings->push_back(absl::StrFormat(
        "quaternions were up to %.3f off unit length; normalised",
        clip.quaternion_drift));
  }
  for (const std::string& joint : map.unmapped) {
    for (const SourcePose& pose : clip.poses) {
      const int index = clip.skeleton.Find(joint);
      if (std::abs(pose.rotation[index].w()) > 1 - 1e-6) continue;
      warnings->push_back(absl::StrCat(
          "the character has no joint for ", joint, "; its rotation is lost"));
      break;
    }
  }
}

}  // namespace

absl::StatusOr<Retargeted> RetargetClip(const ImportModel& model,
                                        const SourceClip& clip,
                                        const RetargetOptions& options) {
  SINEW_RETURN_IF_ERROR(CheckOptions(options));
  SINEW_ASSIGN_OR_RETURN(
      const BodyMap map,
      MakeBodyMap(clip.skeleton, *model.model, model.semantics));
  Retargeted result;
  result.warnings = clip.warnings;
  Warn(clip, map, &result.warnings);
  const SourceTrack track = MakeTrack(clip, options.rate);
  result.motion = FitMotion(track, clip.skeleton, map, *model.model);
  result.retiming = track.retiming;
  result.seam_max_rad = track.seam_max_rad;
  Dynamics dynamics(model);
  std::vector<bool> supported = FindSupport(&dynamics, result.motion);
  CalibrateGround(&dynamics, supported, &result.motion);
  supported = FindSupport(&dynamics, result.motion, /*ground=*/0);
  CalibrateGround(&dynamics, supported, &result.motion);
  MakeFlightsBallistic(&dynamics, supported, &result.motion);
  Settle(options, supported, &dynamics, &result);
  const JointFitError fit = MeasureJointFit(track, clip.skeleton, map,
                                            *model.model, result.motion);
  result.quality.set_joint_fit_max_rad(fit.max_rad);
  result.quality.set_joint_fit_mean_rad(fit.mean_rad);
  return result;
}

}  // namespace sinew::import
