#include "sim/import/retarget/quality.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "sim/import/retarget/ground.h"
#include "sim/import/retarget/self_contact.h"

namespace sinew::import {
namespace {

using Eigen::Vector3d;
using Eigen::VectorXd;

// Contact state of the feet, and of the whole body, in the frame's pose.
void MeasureContact(const Dynamics& dynamics, FrameDynamics* frame) {
  const ImportModel& model = dynamics.import_model();
  const std::vector<Vector3d> lowest = dynamics.LowestPoints();
  frame->contact.assign(model.feet.size(), false);
  frame->foot_points.clear();
  frame->lowest = INFINITY;
  frame->lowest_foot = INFINITY;
  for (size_t i = 0; i < lowest.size(); ++i) {
    const int foot = model.FootOf(static_cast<int>(i));
    frame->lowest = std::min(frame->lowest, lowest[i].z());
    if (foot >= 0) {
      frame->foot_points.push_back(lowest[i]);
      frame->lowest_foot = std::min(frame->lowest_foot, lowest[i].z());
    }
    if (lowest[i].z() > kFootContactHeight) continue;
    const Vector3d velocity =
        dynamics.PointJacobian(model.points[i].body, lowest[i]) * frame->qvel;
    if (velocity.norm() >= kContactSpeed) continue;
    frame->bears = true;
    if (foot >= 0) frame->contact[foot] = true;
  }
}

// [ground points of feet, in the model's order] index of the foot.
std::vector<int> FeetOfPoints(const ImportModel& model) {
  std::vector<int> feet;
  for (int i = 0; i < static_cast<int>(model.points.size()); ++i) {
    const int foot = model.FootOf(i);
    if (foot >= 0) feet.push_back(foot);
  }
  return feet;
}

// Distance along the floor of the ground point of `foot` that stays lowest.
double SlideOfFoot(const FrameDynamics& from, const FrameDynamics& to,
                   const std::vector<int>& feet, int foot) {
  double lowest = INFINITY;
  double slide = 0;
  for (size_t i = 0; i < feet.size(); ++i) {
    if (feet[i] != foot) continue;
    const double height =
        std::max(from.foot_points[i].z(), to.foot_points[i].z());
    if (height >= lowest) continue;
    lowest = height;
    slide = (to.foot_points[i] - from.foot_points[i]).head<2>().norm();
  }
  return slide;
}

double FootSkate(const ImportModel& model, double rate,
                 const std::vector<FrameDynamics>& frames) {
  const std::vector<int> feet = FeetOfPoints(model);
  double sum = 0;
  int count = 0;
  for (size_t t = 0; t + 1 < frames.size(); ++t) {
    for (int f = 0; f < static_cast<int>(model.feet.size()); ++f) {
      if (!frames[t].contact[f] || !frames[t + 1].contact[f]) continue;
      sum += rate * SlideOfFoot(frames[t], frames[t + 1], feet, f);
      ++count;
    }
  }
  return count == 0 ? 0 : sum / count;
}

// Positions of all body frames, [3, nbody].
Eigen::Matrix3Xd BodyPositions(Dynamics* dynamics, const VectorXd& qpos) {
  dynamics->SetPose(qpos);
  return Eigen::Map<const Eigen::Matrix3Xd>(dynamics->data().xpos, 3,
                                            dynamics->model().nbody);
}

double LoopSeam(Dynamics* dynamics, const ModelMotion& motion) {
  const int n = motion.frames();
  if (!motion.loops || n < 2) return 0;
  const mjModel& model = dynamics->model();
  const VectorXd step =
      Displacement(model, motion.qpos[n - 2], motion.qpos[n - 1]);
  VectorXd next = motion.qpos[n - 1];
  mj_integratePos(&model, next.data(), step.data(), 1);
  const Eigen::Matrix3Xd expected = BodyPositions(dynamics, FrameAt(motion, n));
  const Eigen::Matrix3Xd found = BodyPositions(dynamics, next);
  const auto distance = (expected - found).colwise().norm();
  return distance.sum() / (model.nbody - 1);  // the world contributes 0
}

// 99th percentile over frames of the feet's depth.
double FootPenetration(const std::vector<FrameDynamics>& frames) {
  std::vector<double> depths;
  for (const FrameDynamics& frame : frames) {
    depths.push_back(std::max(0.0, -frame.lowest_foot));
  }
  return Percentile(std::move(depths), 0.99);
}

}  // namespace

std::vector<FrameDynamics> AnalyseMotion(Dynamics* dynamics,
                                         const ModelMotion& motion) {
  const ImportModel& model = dynamics->import_model();
  std::vector<FrameDynamics> frames(motion.frames());
  for (int t = 0; t < motion.frames(); ++t) {
    FrameDynamics& frame = frames[t];
    Rates(dynamics->model(), motion, t, &frame.qvel, &frame.qacc);
    const VectorXd required =
        dynamics->Inverse(motion.qpos[t], frame.qvel, frame.qacc);
    const ContactFit fit =
        FitContacts(*dynamics, FindContacts(*dynamics), required);
    frame.residual = fit.remainder.head<6>();
    frame.torque.resize(static_cast<int>(model.joints.size()));
    for (size_t j = 0; j < model.joints.size(); ++j) {
      const int dof = model.joints[j].dof_address;
      frame.torque[static_cast<int>(j)] = fit.remainder[dof];
      frame.peak_joint_speed =
          std::max(frame.peak_joint_speed, std::abs(frame.qvel[dof]));
      frame.peak_joint_acceleration =
          std::max(frame.peak_joint_acceleration, std::abs(frame.qacc[dof]));
    }
    frame.root_speed = frame.qvel.head<3>().norm();
    MeasureContact(*dynamics, &frame);
  }
  return frames;
}

std::vector<double> SelfDepths(Dynamics* dynamics, const ModelMotion& motion) {
  const SelfContacts self(dynamics->import_model());
  std::vector<double> depths;
  for (const VectorXd& qpos : motion.qpos) {
    dynamics->SetPose(qpos);
    depths.push_back(self.Deepest(dynamics->data()));
  }
  return depths;
}

double LargestRise(const std::vector<double>& before,
                   const std::vector<double>& after) {
  double rise = 0;
  for (size_t t = 0; t < after.size(); ++t) {
    rise = std::max(rise, after[t] - before[t]);
  }
  return rise;
}

v1::ClipQuality MeasureQuality(Dynamics* dynamics, const ModelMotion& motion,
                               const std::vector<FrameDynamics>& frames) {
  const ImportModel& model = dynamics->import_model();
  double force = 0, torque = 0, ratio = 0, penetration = 0, floating = 0;
  double speed = 0;
  double acceleration = 0, root_speed = 0;
  int bearing = 0, airborne = 0;
  for (const FrameDynamics& frame : frames) {
    force += frame.residual.head<3>().norm() / model.weight();
    torque += frame.residual.tail<3>().norm();
    for (size_t j = 0; j < model.joints.size(); ++j) {
      ratio = std::max(ratio, std::abs(frame.torque[static_cast<int>(j)]) /
                                  model.joints[j].torque_limit);
    }
    penetration = std::max(penetration, -frame.lowest);
    speed = std::max(speed, frame.peak_joint_speed);
    acceleration = std::max(acceleration, frame.peak_joint_acceleration);
    root_speed = std::max(root_speed, frame.root_speed);
    airborne += frame.lowest > kFootContactHeight;
    if (frame.bears) {
      ++bearing;
      floating += std::max(0.0, frame.lowest);
    }
  }
  const std::vector<double> depths = SelfDepths(dynamics, motion);
  const double deepest = *std::max_element(depths.begin(), depths.end());
  const double count = static_cast<double>(frames.size());
  v1::ClipQuality quality;
  quality.set_residual_force_bodyweights(force / count);
  quality.set_residual_torque_nm(torque / count);
  quality.set_peak_torque_ratio(ratio);
  quality.set_penetration_max_m(penetration);
  quality.set_floating_mean_m(bearing == 0 ? 0 : floating / bearing);
  quality.set_peak_joint_speed(speed);
  quality.set_peak_joint_acceleration(acceleration);
  quality.set_peak_root_speed(root_speed);
  quality.set_self_penetration_max_m(deepest);
  quality.set_airborne_share(airborne / count);
  quality.set_foot_penetration_p99_m(FootPenetration(frames));
  quality.set_foot_skate_m_per_s(FootSkate(model, motion.rate, frames));
  quality.set_loop_seam_m(LoopSeam(dynamics, motion));
  return quality;
}

}  // namespace sinew::import
