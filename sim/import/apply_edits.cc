#include "sim/import/apply_edits.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "common/status_macros.h"
#include "sim/import/retarget/quality.h"
#include "sim/motion/rotation.h"

namespace sinew::import {
namespace {

using Joints = std::vector<std::vector<Eigen::Vector3d>>;

// The frames that Trim keeps.
void TrimJoints(const EditOptions& options, double rate, Joints* joints) {
  const double last = static_cast<double>(joints->size()) - 1;
  const auto begin = std::lround(std::clamp(options.from_s * rate, 0., last));
  const auto end = std::lround(std::clamp(options.to_s * rate, 0., last)) + 1;
  *joints =
      Joints(joints->begin() + begin, joints->begin() + std::max(end, begin));
}

// From the place and heading of `before` to those of `after`: a turn about the
// vertical and a move over the floor.
Eigen::Isometry3d PlanarMove(const Eigen::VectorXd& before,
                             const Eigen::VectorXd& after) {
  const auto yaw = [](const Eigen::VectorXd& qpos) {
    return motion::Yaw(motion::FromWxyz(qpos.data() + 3).normalized());
  };
  Eigen::Isometry3d move = Eigen::Isometry3d::Identity();
  move.rotate(
      Eigen::AngleAxisd(yaw(after) - yaw(before), Eigen::Vector3d::UnitZ()));
  const Eigen::Vector3d from(before[0], before[1], 0),
      to(after[0], after[1], 0);
  move.translation() = to - move.linear() * from;
  return move;
}

// Figures that Edit does not change the meaning of.
void KeepFiguresOfSource(const v1::ClipQuality& whole,
                         v1::ClipQuality* edited) {
  edited->set_joint_fit_max_rad(whole.joint_fit_max_rad());
  edited->set_joint_fit_mean_rad(whole.joint_fit_mean_rad());
  edited->set_retarget_error_m(whole.retarget_error_m());
  *edited->mutable_retarget_errors() = whole.retarget_errors();
  edited->set_joint_limit_violation_share(whole.joint_limit_violation_share());
  edited->set_self_penetration_added_m(whole.self_penetration_added_m());
}

}  // namespace

absl::Status ApplyEdits(const MotionMirror& mirror, const EditOptions& options,
                        Dynamics* dynamics, Retargeted* played) {
  SINEW_ASSIGN_OR_RETURN(ModelMotion motion,
                         Edit(dynamics, mirror, played->motion, options));
  Joints joints = std::move(played->source_joints);
  const size_t all = joints.size();
  if (!joints.empty()) TrimJoints(options, motion.rate, &joints);
  // Closing a loop changes frames in ways that the source is not changed in; a
  // clip that loops is not closed, but a piece of one is.
  const bool loops = played->motion.loops && joints.size() == all;
  if (options.loop && !loops) joints.clear();
  if (options.mirror) {
    for (auto& frame : joints) {
      for (Eigen::Vector3d& joint : frame) joint.y() = -joint.y();
    }
  }
  if (options.align_heading) {
    const Eigen::VectorXd before = motion.qpos.front();
    motion = AlignHeading(motion);
    const Eigen::Isometry3d move = PlanarMove(before, motion.qpos.front());
    for (auto& frame : joints) {
      for (Eigen::Vector3d& joint : frame) joint = move * joint;
    }
  }
  played->motion = std::move(motion);
  played->source_joints = std::move(joints);
  if (played->source_joints.empty()) played->source_parents.clear();
  played->frames = AnalyseMotion(dynamics, played->motion);
  v1::ClipQuality quality =
      MeasureQuality(dynamics, played->motion, played->frames);
  KeepFiguresOfSource(played->quality, &quality);
  played->quality = std::move(quality);
  return absl::OkStatus();
}

bool HasEdits(const EditOptions& options) {
  return options.from_s != 0 ||
         options.to_s != std::numeric_limits<double>::infinity() ||
         options.loop || options.mirror || options.align_heading;
}

}  // namespace sinew::import
