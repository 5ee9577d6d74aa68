#ifndef SINEW_SIM_IMPORT_RETARGET_MODEL_MOTION_H_
#define SINEW_SIM_IMPORT_RETARGET_MODEL_MOTION_H_

#include <mujoco/mujoco.h>

#include <Eigen/Dense>
#include <vector>

#include "sim/import/retarget/body_map.h"
#include "sim/import/retarget/role_track.h"
#include "sim/import/retarget/source_track.h"

namespace sinew::import {

// A motion of a model: one qpos per frame at a constant rate. The model has one
// free joint, its first, and hinges.
struct ModelMotion {
  double rate = 0;  // frames per second
  bool loops = false;
  Cycle cycle;
  std::vector<Eigen::VectorXd> qpos;  // [frames][nq]

  int frames() const { return static_cast<int>(qpos.size()); }
  double dt() const { return 1 / rate; }
};

// Tangent coordinates [nv] of the way from pose `a` to pose `b`.
Eigen::VectorXd Displacement(const mjModel& model, const Eigen::VectorXd& a,
                             const Eigen::VectorXd& b);

// Cuts hinges to their ranges.
void ClampHinges(const mjModel& model, ModelMotion* motion);

// Frame `t` of a looping motion continued for ever both ways, moved by the
// cycle as often as it takes; of others `t` must be a frame.
Eigen::VectorXd FrameAt(const ModelMotion& motion, int t);

// Keeps a loop's cycle the same map of the world after the root of its first
// frame, about which it turns, was moved from `old_root`.
void KeepCycle(const Eigen::Vector3d& old_root, ModelMotion* motion);

// qvel and qacc [nv] of frame `t` in MuJoCo's convention, from the frames
// beside it: v = (r+ - r-) / 2 dt and a = (r+ + r-) / dt^2 with r+- the
// displacements to the neighbours, both second-order accurate and without lag.
// At the ends of a motion that does not loop, v is one-sided (second order) and
// a is that of the frame beside; with two frames a is zero.
void Rates(const mjModel& model, const ModelMotion& motion, int t,
           Eigen::VectorXd* qvel, Eigen::VectorXd* qacc);

// Plays a track on a model: every mapped hinge chain by FitJoints, root by the
// hips' middle scaled with the legs; other hinges at qpos0. No ground contact
// yet. `cut_share`, if given, is set to the share of (frame, hinge) that a
// limit cut (FitJoints).
ModelMotion FitMotion(const RoleTrack& track, const BodyMap& map,
                      const mjModel& model, double* cut_share = nullptr);

// Angles between the joint rotations of the track and those that the hinges of
// `motion` make: largest and mean over joints and frames.
struct JointFitError {
  double max_rad = 0;
  double mean_rad = 0;
};
JointFitError MeasureJointFit(const RoleTrack& track, const BodyMap& map,
                              const mjModel& model, const ModelMotion& motion);

}  // namespace sinew::import

#endif  // SINEW_SIM_IMPORT_RETARGET_MODEL_MOTION_H_
