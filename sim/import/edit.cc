#include "sim/import/edit.h"

#include <algorithm>
#include <cmath>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "common/status_macros.h"
#include "sim/character/mirror_joints.h"
#include "sim/motion/rotation.h"

namespace sinew::import {
namespace {

using Eigen::Quaterniond;
using Eigen::Vector3d;
using Eigen::VectorXd;

Quaterniond RootRotation(const VectorXd& qpos) {
  return motion::FromWxyz(qpos.data() + 3);
}

}  // namespace

absl::StatusOr<ModelMotion> Trim(const ModelMotion& motion, double from_s,
                                 double to_s) {
  if (!(from_s >= 0 && to_s > from_s)) {
    return absl::InvalidArgumentError(
        absl::StrCat("trim: expected 0 <= from < to, found from ", from_s,
                     " s to ", to_s, " s"));
  }
  const int end = motion.frames() - 1;
  // Clamped before rounding: seconds may be anything.
  const auto frame = [&](double seconds) {
    return static_cast<int>(
        std::lround(std::min(seconds * motion.rate, static_cast<double>(end))));
  };
  const int first = frame(from_s);
  const int last = frame(to_s);
  if (last <= first) {
    return absl::InvalidArgumentError(absl::StrCat(
        "trim: expected at least two frames, found ", last - first + 1,
        " from ", from_s, " s to ", to_s, " s of ", motion.frames(),
        " frames at ", motion.rate, " per second"));
  }
  ModelMotion trimmed = motion;
  if (first == 0 && last == end) return trimmed;
  trimmed.loops = false;
  trimmed.cycle = Cycle();
  trimmed.qpos.assign(motion.qpos.begin() + first,
                      motion.qpos.begin() + last + 1);
  return trimmed;
}

ModelMotion AlignHeading(const ModelMotion& motion) {
  ModelMotion aligned = motion;
  const Quaterniond turn =
      motion::YawRotation(-motion::Yaw(RootRotation(motion.qpos[0])));
  const Vector3d origin(motion.qpos[0].x(), motion.qpos[0].y(), 0);
  for (VectorXd& qpos : aligned.qpos) {
    const Vector3d place = qpos.head<3>();
    qpos.head<3>() = turn * (place - origin);
    motion::ToWxyz(turn * RootRotation(qpos), qpos.data() + 3);
  }
  const Vector3d cycle = turn * Vector3d(motion.cycle.x, motion.cycle.y, 0);
  aligned.cycle = {.x = cycle.x(), .y = cycle.y(), .yaw = motion.cycle.yaw};
  return aligned;
}

absl::StatusOr<MotionMirror> MakeMotionMirror(
    const character::Character& character) {
  MotionMirror mirror;
  SINEW_ASSIGN_OR_RETURN(mirror.joints, character::MirrorJoints(character));
  for (const character::JointInfo& joint : character.joints()) {
    mirror.addresses.push_back(joint.qpos_address);
  }
  return mirror;
}

ModelMotion Mirror(const MotionMirror& mirror, const ModelMotion& motion) {
  ModelMotion mirrored = motion;
  for (int t = 0; t < motion.frames(); ++t) {
    const VectorXd& from = motion.qpos[t];
    VectorXd& to = mirrored.qpos[t];
    to[1] = -from[1];
    // S R S of a rotation about w x y z: the axis is mirrored, the turn too.
    to[4] = -from[4];
    to[6] = -from[6];
    for (size_t j = 0; j < mirror.addresses.size(); ++j) {
      const int source = mirror.addresses[mirror.joints.source[j]];
      to[mirror.addresses[j]] =
          static_cast<double>(mirror.joints.sign[j]) * from[source];
    }
  }
  mirrored.cycle.y = -motion.cycle.y;
  mirrored.cycle.yaw = -motion.cycle.yaw;
  return mirrored;
}

absl::StatusOr<ModelMotion> Edit(Dynamics* dynamics, const MotionMirror& mirror,
                                 const ModelMotion& motion,
                                 const EditOptions& options) {
  SINEW_ASSIGN_OR_RETURN(ModelMotion edited,
                         Trim(motion, options.from_s, options.to_s));
  if (options.loop && !edited.loops) {
    SINEW_ASSIGN_OR_RETURN(const Loop loop,
                           FindLoop(dynamics, edited, options.loop_options));
    edited = CloseLoop(edited, loop);
  }
  if (options.mirror) edited = Mirror(mirror, edited);
  return edited;
}

}  // namespace sinew::import
