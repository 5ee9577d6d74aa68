#include "sim/import/retarget/retarget.h"

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_join.h"
#include "common/status_macros.h"
#include "sim/import/formats/first_frame.h"
#include "sim/import/maps/draft_map.h"
#include "sim/import/maps/skeleton_maps.h"
#include "sim/import/retarget/body_map.h"
#include "sim/import/retarget/dynamics.h"
#include "sim/import/retarget/foot_lock.h"
#include "sim/import/retarget/ground.h"
#include "sim/import/retarget/pose_fit.h"
#include "sim/import/retarget/role_track.h"
#include "sim/import/retarget/scaled_source.h"
#include "sim/import/retarget/settle.h"
#include "sim/import/retarget/source_track.h"

namespace sinew::import {
namespace {

using Eigen::Vector3d;
using Eigen::VectorXd;

// Drift of a source quaternion's norm that is worth a word.
constexpr double kDriftWarning = 0.01;

void Warn(const SourceClip& clip, const BodyMap& map,
          std::vector<std::string>* warnings) {
  if (clip.quaternion_drift > kDriftWarning) {
    warnings->push_back(absl::StrFormat(
        "quaternions were up to %.3f off unit length; normalised",
        clip.quaternion_drift));
  }
  for (const std::string& role : map.unmapped) {
    warnings->push_back(absl::StrCat("the character has no joint for ", role,
                                     "; its rotation is lost"));
  }
}

// The map that was asked for, else one that comes with the project, else a
// draft.
absl::StatusOr<v1::SkeletonMap> ChooseMap(const SourceClip& clip,
                                          const RetargetOptions& options,
                                          std::vector<std::string>* warnings) {
  if (options.map != nullptr) return *options.map;
  SINEW_ASSIGN_OR_RETURN(const std::vector<v1::SkeletonMap> maps,
                         KnownSkeletonMaps());
  const v1::SkeletonMap* found = FindMapFor(maps, clip.skeleton);
  if (found != nullptr) return *found;
  SINEW_ASSIGN_OR_RETURN(v1::SkeletonMap draft,
                         DraftSkeletonMap(clip.skeleton, kDraftName));
  std::vector<std::string> pairs;
  for (const v1::JointRole& joint : draft.joints()) {
    pairs.push_back(absl::StrCat(joint.source(), ": ", joint.role()));
  }
  warnings->push_back(
      absl::StrCat("no skeleton map fits; drafted one, please check: ",
                   absl::StrJoin(pairs, ", ")));
  return draft;
}

// From joint angles to poses on the floor: limbs where the source has them,
// then the floor under them, then feet that stay. Returns the support.
std::vector<bool> PlacePoses(const RoleTrack& track, const BodyMap& map,
                             const StopToken& stop, Dynamics* dynamics,
                             Retargeted* result) {
  ModelMotion& motion = result->motion;
  ScaledSource& scaled = result->source_joints;
  scaled = ScaleSource(track, map, motion, dynamics);
  PoseFitOptions on_the_floor;
  on_the_floor.stop = stop;
  PoseFitOptions in_the_air = on_the_floor;  // the floor is not yet known
  in_the_air.penetration = 0;
  in_the_air.iterations = 3;
  const std::vector<std::vector<Lock>> no_locks(motion.frames());
  motion = FitPoses(track, map, scaled, no_locks, motion, dynamics, in_the_air);
  const std::vector<VectorXd> before = motion.qpos;
  std::vector<bool> supported = PlaceOnFloor(dynamics, &motion);
  for (int t = 0; t < motion.frames(); ++t) {
    const Vector3d moved = motion.qpos[t].head<3>() - before[t].head<3>();
    for (Vector3d& place : scaled[t]) place += moved;
  }
  motion = FitPoses(track, map, scaled, FindLocks(supported, motion, dynamics),
                    motion, dynamics, on_the_floor);
  return supported;
}

}  // namespace

absl::StatusOr<Retargeted> RetargetClip(const ImportModel& model,
                                        const SourceClip& source,
                                        const RetargetOptions& options) {
  SINEW_RETURN_IF_ERROR(CheckOptions(options));
  SINEW_RETURN_IF_ERROR(CheckModel(model));
  SINEW_RETURN_IF_ERROR(CheckFrames(source.name, source.duration(), options));
  Retargeted result;
  result.warnings = source.warnings;
  SINEW_ASSIGN_OR_RETURN(const v1::SkeletonMap roles,
                         ChooseMap(source, options, &result.warnings));
  SourceClip clip = source;
  if (roles.first_frame_is_rest() && FirstFrameIsRest(clip)) {
    DropFirstPose(clip);
  }
  result.map = roles.name();
  SINEW_ASSIGN_OR_RETURN(
      const RoleTrack track,
      MakeRoleTrack(MakeTrack(clip, options.rate), clip.skeleton, roles));
  SINEW_ASSIGN_OR_RETURN(const BodyMap map, MakeBodyMap(track, model));
  Warn(clip, map, &result.warnings);
  double cut_share = 0;
  result.motion = FitMotion(track, map, *model.model, &cut_share);
  result.retiming = track.retiming;
  result.source_parents = track.parent;
  Dynamics dynamics(model);
  const std::vector<double> depths = SelfDepths(&dynamics, result.motion);
  const std::vector<bool> supported =
      PlacePoses(track, map, options.stop, &dynamics, &result);
  SINEW_RETURN_IF_ERROR(CheckStop(options));
  SINEW_RETURN_IF_ERROR(Settle(options, supported, &dynamics, &result));
  v1::ClipQuality& quality = result.quality;
  const JointFitError fit =
      MeasureJointFit(track, map, *model.model, result.motion);
  quality.set_joint_fit_max_rad(fit.max_rad);
  quality.set_joint_fit_mean_rad(fit.mean_rad);
  quality.set_joint_limit_violation_share(cut_share);
  quality.set_self_penetration_added_m(
      LargestRise(depths, SelfDepths(&dynamics, result.motion)));
  MeasureRetargetError(track, map, result.source_joints, result.motion,
                       &dynamics, &quality);
  return result;
}

}  // namespace sinew::import
