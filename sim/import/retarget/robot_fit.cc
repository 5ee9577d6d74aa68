#include <algorithm>
#include <cmath>
#include <numbers>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_join.h"
#include "absl/strings/string_view.h"
#include "common/status_macros.h"
#include "sim/import/retarget/dynamics.h"
#include "sim/import/retarget/ground.h"
#include "sim/import/retarget/retarget.h"
#include "sim/import/retarget/settle.h"
#include "sim/import/retarget/source_track.h"
#include "sim/motion/rotation.h"

namespace sinew::import {
namespace {

using Eigen::Quaterniond;
using Eigen::Vector3d;
using Eigen::VectorXd;

// Beyond a limit by more than this is worth a word, rad.
constexpr double kLimitTolerance = 0.0175;
// Lowest points further from the floor than this need calibration, m.
constexpr double kFloorTolerance = 0.01;

// Which column of the clip moves which joint of the character; -1: none.
struct Columns {
  std::vector<int> of_joint;        // [ImportModel::joints]
  std::vector<std::string> unused;  // names of the clip
  std::vector<std::string> missing;
};

Columns MatchColumns(const ImportModel& model, const RobotClip& clip) {
  Columns columns;
  std::vector<bool> used(clip.joints.size(), false);
  for (const ImportJoint& joint : model.joints) {
    const int id = model.model->dof_jntid[joint.dof_address];
    const std::string name = mj_id2name(model.model, mjOBJ_JOINT, id);
    const auto found = std::find(clip.joints.begin(), clip.joints.end(), name);
    const auto column = found - clip.joints.begin();
    columns.of_joint.push_back(
        found == clip.joints.end() ? -1 : static_cast<int>(column));
    if (found == clip.joints.end()) {
      columns.missing.push_back(name);
    } else {
      used[column] = true;
    }
  }
  for (size_t i = 0; i < used.size(); ++i) {
    if (!used[i]) columns.unused.push_back(clip.joints[i]);
  }
  return columns;
}

absl::Status CheckColumns(const ImportModel& model, const RobotClip& clip,
                          const Columns& columns) {
  const size_t found = model.joints.size() - columns.missing.size();
  if (2 * found >= model.joints.size()) return absl::OkStatus();
  return absl::InvalidArgumentError(absl::StrCat(
      clip.name, ": expected at least half of the character's ",
      model.joints.size(), " joints among the clip's columns, found ", found,
      "; missing: ", absl::StrJoin(columns.missing, ", ")));
}

void WarnColumns(const Columns& columns, std::vector<std::string>* warnings) {
  if (!columns.missing.empty()) {
    warnings->push_back(absl::StrCat("the clip has no column for ",
                                     absl::StrJoin(columns.missing, ", "),
                                     "; left at the default position"));
  }
  if (!columns.unused.empty()) {
    warnings->push_back(absl::StrCat("the character has no joint ",
                                     absl::StrJoin(columns.unused, ", "),
                                     "; the column is lost"));
  }
}

// Faster than any robot: a jump of the recording. What is measured of a clip
// does not show it, since a clip is smoothed and put on the floor before.
constexpr double kMostRootSpeed = 15;   // m/s
constexpr double kMostJointSpeed = 60;  // rad/s

void WarnJumps(const RobotClip& clip, std::vector<std::string>* warnings) {
  const auto jumps = [&](absl::string_view what, size_t frame, double by,
                         absl::string_view unit) {
    warnings->push_back(absl::StrFormat(
        "%s jumps by %.3g %s from frame %d to the next, in %.3g s: the "
        "recording is damaged there, or its units are others",
        what, by, unit, frame - 1,
        clip.poses[frame].time - clip.poses[frame - 1].time));
  };
  bool root = false;
  std::vector<bool> told(clip.joints.size(), false);
  for (size_t t = 1; t < clip.poses.size(); ++t) {
    const RobotPose& before = clip.poses[t - 1];
    const RobotPose& now = clip.poses[t];
    const double seconds = now.time - before.time;
    const double moved = (now.root_position - before.root_position).norm();
    if (!root && moved > kMostRootSpeed * seconds) {
      jumps("the root", t, moved, "m");
      root = true;
    }
    for (size_t j = 0; j < told.size(); ++j) {
      const double turned = motion::Unwrap(now.joints[j] - before.joints[j], 0);
      if (told[j] || std::abs(turned) <= kMostJointSpeed * seconds) continue;
      jumps(clip.joints[j], t, turned, "rad");
      told[j] = true;
    }
  }
}

// Of an angle that is beyond its joint's range by more than half a turn only
// what is left of whole turns is used.
void WarnTurns(const ImportModel& model, const Columns& columns,
               const RobotClip& clip, std::vector<std::string>* warnings) {
  for (size_t j = 0; j < model.joints.size(); ++j) {
    const int column = columns.of_joint[j];
    if (column < 0) continue;
    const ImportJoint& joint = model.joints[j];
    for (size_t t = 0; t < clip.poses.size(); ++t) {
      const double angle = clip.poses[t].joints[column];
      const double beyond = std::max(joint.lower - angle, angle - joint.upper);
      if (!(beyond > std::numbers::pi)) continue;
      warnings->push_back(absl::StrFormat(
          "%s is at %.3g rad in frame %d, far beyond its range of %.3g to "
          "%.3g: "
          "whole turns are left out",
          clip.joints[column], angle, t, joint.lower, joint.upper));
      break;
    }
  }
}

// The clip as balls that turn about x, so that closing loops and resampling is
// the same code for all clips.
SourceClip AsBalls(const RobotClip& clip) {
  SourceClip balls;
  balls.name = clip.name;
  balls.loops = clip.loops;
  balls.skeleton.joints.push_back({"root", -1, Vector3d::Zero()});
  for (const std::string& joint : clip.joints) {
    balls.skeleton.joints.push_back({joint, 0, Vector3d::Zero()});
  }
  for (const RobotPose& pose : clip.poses) {
    std::vector<Quaterniond> rotation = {pose.root_rotation};
    for (const double angle : pose.joints) {
      rotation.push_back(motion::Exp(angle * Vector3d::UnitX()));
    }
    balls.poses.push_back({pose.time, pose.root_position, rotation});
  }
  return balls;
}

// The joint's angle, of the representatives modulo 2 pi the one nearest to the
// middle of its range; without limits, to `before`.
double Angle(const mjModel& model, int joint, const Quaterniond& ball,
             double before) {
  const double angle = 2 * std::atan2(ball.x(), ball.w());
  const double* range = model.jnt_range + 2 * joint;
  return motion::Unwrap(
      angle, model.jnt_limited[joint] ? (range[0] + range[1]) / 2 : before);
}

// Fills qpos; returns the share of angles beyond a limit.
double FillPoses(const ImportModel& model, const Columns& columns,
                 const SourceTrack& track, ModelMotion* motion) {
  const mjModel& m = *model.model;
  int beyond = 0;
  for (int t = 0; t < track.frames(); ++t) {
    VectorXd qpos = Eigen::Map<const VectorXd>(m.qpos0, m.nq);
    qpos.head<3>() = track.root_position[t];
    motion::ToWxyz(track.rotation[t][0], qpos.data() + 3);
    for (size_t j = 0; j < model.joints.size(); ++j) {
      const ImportJoint& joint = model.joints[j];
      const int id = m.dof_jntid[joint.dof_address];
      const int column = columns.of_joint[j];
      // A joint that turns on does not jump back by 2 pi; in a loop it must
      // come back to where it began.
      const double before =
          t == 0 || track.loops ? 0 : motion->qpos.back()[joint.qpos_address];
      const double wanted =
          column < 0 ? joint.default_position
                     : Angle(m, id, track.rotation[t][column + 1], before);
      double& angle = qpos[joint.qpos_address];
      angle = std::clamp(wanted, joint.lower, joint.upper);
      beyond += std::abs(angle - wanted) > kLimitTolerance;
    }
    motion->qpos.push_back(qpos);
  }
  const double angles =
      static_cast<double>(model.joints.size()) * track.frames();
  return beyond / angles;
}

// Whether a supported frame's lowest point lies off the floor.
bool IsOffTheFloor(Dynamics* dynamics, const std::vector<bool>& supported,
                   const ModelMotion& motion) {
  for (int t = 0; t < motion.frames(); ++t) {
    if (!supported[t]) continue;
    dynamics->SetPose(motion.qpos[t]);
    if (std::abs(dynamics->LowestHeight()) > kFloorTolerance) return true;
  }
  return false;
}

}  // namespace

absl::StatusOr<Retargeted> FitRobotClip(const ImportModel& model,
                                        const RobotClip& clip,
                                        const RetargetOptions& options) {
  SINEW_RETURN_IF_ERROR(CheckOptions(options));
  SINEW_RETURN_IF_ERROR(CheckModel(model));
  SINEW_RETURN_IF_ERROR(CheckFrames(clip.name, clip.duration(), options));
  const Columns columns = MatchColumns(model, clip);
  SINEW_RETURN_IF_ERROR(CheckColumns(model, clip, columns));
  const SourceTrack track = MakeTrack(AsBalls(clip), options.rate);
  Retargeted result;
  result.warnings = clip.warnings;
  WarnColumns(columns, &result.warnings);
  WarnJumps(clip, &result.warnings);
  WarnTurns(model, columns, clip, &result.warnings);
  result.retiming = track.retiming;
  ModelMotion& motion = result.motion;
  motion.rate = track.rate;
  motion.loops = track.loops;
  motion.cycle = track.cycle;
  const double beyond = FillPoses(model, columns, track, &motion);
  Dynamics dynamics(model);
  const std::vector<double> depths = SelfDepths(&dynamics, motion);
  std::vector<bool> supported = FindSupport(&dynamics, motion);
  if (IsOffTheFloor(&dynamics, supported, motion)) {
    supported = PlaceOnFloor(&dynamics, &motion);
  }
  SINEW_RETURN_IF_ERROR(Settle(options, supported, &dynamics, &result));
  result.quality.set_joint_limit_violation_share(beyond);
  result.quality.set_self_penetration_added_m(
      LargestRise(depths, SelfDepths(&dynamics, motion)));
  return result;
}

}  // namespace sinew::import
