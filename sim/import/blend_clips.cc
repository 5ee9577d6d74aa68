#include "sim/import/blend_clips.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/string_view.h"
#include "common/status_macros.h"
#include "sim/import/edit.h"
#include "sim/import/retarget/ground.h"
#include "sim/import/retarget/settle.h"

namespace sinew::import {
namespace {

absl::Status CheckKept(const std::string& which, const KeptSeconds& kept) {
  if (kept.from_s >= 0 && kept.to_s > kept.from_s) return absl::OkStatus();
  return absl::InvalidArgumentError(
      absl::StrCat("blend: ", which, " clip: expected 0 <= from < to, found ",
                   kept.from_s, " s to ", kept.to_s, " s"));
}

absl::StatusOr<ModelMotion> Keep(absl::string_view which,
                                 const KeptSeconds& kept,
                                 const ModelMotion& motion) {
  auto result = Trim(motion, kept.from_s, kept.to_s);
  if (result.ok()) return result;
  return absl::Status(
      result.status().code(),
      absl::StrCat("blend: ", which, " clip: ", result.status().message()));
}

// The mean of two means, by frames.
class Mean {
 public:
  Mean(const Retargeted& first, const Retargeted& second)
      : share_(static_cast<double>(first.motion.frames()) /
               (first.motion.frames() + second.motion.frames())) {}

  double operator()(double first, double second) const {
    return share_ * first + (1 - share_) * second;
  }

 private:
  const double share_;
};

void AddError(const Mean& mean, const v1::RetargetError& error,
              v1::ClipQuality* quality) {
  for (v1::RetargetError& known : *quality->mutable_retarget_errors()) {
    if (known.joint() != error.joint()) continue;
    known.set_mean_m(mean(known.mean_m(), error.mean_m()));
    known.set_max_m(std::max(known.max_m(), error.max_m()));
    return;
  }
  *quality->add_retarget_errors() = error;  // the first clip has no such joint
}

// Figures that the motion alone does not give.
void JoinFiguresOfSource(const Retargeted& first, const Retargeted& second,
                         v1::ClipQuality* quality) {
  const Mean mean(first, second);
  const v1::ClipQuality& a = first.quality;
  const v1::ClipQuality& b = second.quality;
  quality->set_joint_fit_max_rad(
      std::max(a.joint_fit_max_rad(), b.joint_fit_max_rad()));
  quality->set_joint_fit_mean_rad(
      mean(a.joint_fit_mean_rad(), b.joint_fit_mean_rad()));
  quality->set_joint_limit_violation_share(
      mean(a.joint_limit_violation_share(), b.joint_limit_violation_share()));
  quality->set_self_penetration_added_m(
      std::max(a.self_penetration_added_m(), b.self_penetration_added_m()));
  quality->set_retarget_error_m(
      mean(a.retarget_error_m(), b.retarget_error_m()));
  *quality->mutable_retarget_errors() = a.retarget_errors();
  for (const v1::RetargetError& error : b.retarget_errors()) {
    AddError(mean, error, quality);
  }
}

}  // namespace

absl::Status CheckBlendOptions(const BlendOptions& options) {
  SINEW_RETURN_IF_ERROR(CheckBlendGap(options.gap_s));
  SINEW_RETURN_IF_ERROR(CheckKept("first", options.first));
  return CheckKept("second", options.second);
}

absl::StatusOr<Retargeted> BlendClips(const BlendOptions& options,
                                      const Retargeted& first,
                                      const Retargeted& second,
                                      Dynamics* dynamics,
                                      const StopToken& stop) {
  SINEW_RETURN_IF_ERROR(CheckBlendOptions(options));
  SINEW_ASSIGN_OR_RETURN(const ModelMotion before,
                         Keep("first", options.first, first.motion));
  SINEW_ASSIGN_OR_RETURN(const ModelMotion after,
                         Keep("second", options.second, second.motion));
  Retargeted blended;
  SINEW_ASSIGN_OR_RETURN(blended.motion,
                         Blend(dynamics, before, after, options.gap_s));
  blended.map = first.map;
  blended.warnings = first.warnings;
  blended.warnings.insert(blended.warnings.end(), second.warnings.begin(),
                          second.warnings.end());
  // The worse of the two.
  blended.retiming =
      std::abs(first.retiming - 1) > std::abs(second.retiming - 1)
          ? first.retiming
          : second.retiming;
  const std::vector<bool> supported = PlaceOnFloor(dynamics, &blended.motion);
  RetargetOptions settling;
  settling.rate = blended.motion.rate;
  settling.stop = stop;
  SINEW_RETURN_IF_ERROR(Settle(settling, supported, dynamics, &blended));
  JoinFiguresOfSource(first, second, &blended.quality);
  return blended;
}

}  // namespace sinew::import
