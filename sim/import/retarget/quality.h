#ifndef SINEW_SIM_IMPORT_RETARGET_QUALITY_H_
#define SINEW_SIM_IMPORT_RETARGET_QUALITY_H_

#include <Eigen/Dense>
#include <vector>

#include "proto/sinew/v1/motion.pb.h"
#include "sim/import/retarget/contact_fit.h"
#include "sim/import/retarget/dynamics.h"
#include "sim/import/retarget/model_motion.h"

namespace sinew::import {

// Quality figures of a motion on a model; exact definitions of v1::ClipQuality.
// With qvel and qacc from import::Rates in every frame t:
//
// residual: b = M qacc + c (Dynamics::Inverse: no contact, no joint damping),
//   less the floor forces of FitContacts at all points no higher than
//   kContactMargin. residual_force_bodyweights is the mean over frames of the
//   norm of the root's three force rows over the weight; residual_torque_nm the
//   mean norm of its three torque rows.
// peak_torque_ratio: largest |actuator torque| / limit over joints and frames;
//   the actuator torque is the hinge rows of b less the floor forces', that is
//   the whole torque of the law clamp(kp (q* - q) - kd dq), its damping
//   included.
// penetration_max_m: largest depth of any ground point below the floor.
// floating_mean_m: mean over frames with a foot in contact, or with another
//   body's point bearing, of the height of the lowest point above the floor,
//   counted as 0 when below.
// peak_joint_speed: largest |dq| of a hinge.
// foot_skate_m_per_s: mean over (frame, foot) in contact in this frame and the
//   next of the distance that the foot slides along the floor between the two,
//   times the rate. What slides is the lowest point of the ground point that
//   stays lowest (the lesser of the heights' maxima over both frames), so that
//   a foot which rolls over its toe stands.
// loop_seam_m: looping motions: mean over bodies of the distance between the
//   body in frame n, extrapolated from frames n-2 and n-1 at constant
//   velocity of all coordinates, and frame 0 moved by the cycle; 0 for others.
// peak_joint_acceleration, peak_root_speed: largest |ddq| of a hinge, and speed
//   of the root's origin.
// foot_penetration_p99_m: 99th percentile over frames of the depth of the
//   feet's deepest ground point below the floor, 0 above it.
// self_penetration_max_m: largest depth of SelfContacts over frames.
// airborne_share: share of frames whose lowest point is higher than
//   kFootContactHeight.
//
// Not set by MeasureQuality:
// joint_fit_*: MeasureJointFit.
// joint_limit_violation_share: of human clips the share of (frame, hinge) whose
//   angle ended at a limit that the decomposition of the source's rotation
//   exceeds by more than a degree (FitMotion); of robot clips that of the
//   clip's own angles.
// retarget_error_m, retarget_errors: MeasureRetargetError.
// self_penetration_added_m: LargestRise of SelfDepths, from the motion that has
//   the source's joint angles to the one that was made of it.

// A foot touches the floor in a frame if one of its points is no higher than
// this and slower than kContactSpeed, metres.
inline constexpr double kFootContactHeight = 0.025;

// What is known of each frame after the motion is final.
struct FrameDynamics {
  Eigen::VectorXd qvel, qacc;  // [nv]
  Eigen::VectorXd torque;      // [joints] actuator torques, not limited, Nm
  Eigen::Matrix<double, 6, 1> residual;  // root rows: N (world), Nm (body)
  std::vector<bool> contact;             // [feet]
  // [ground points of feet, in the model's order] their lowest points, world.
  std::vector<Eigen::Vector3d> foot_points;
  double lowest = 0;                   // height of the lowest point, m
  double lowest_foot = 0;              // of the feet's, m
  bool bears = false;                  // something is in contact
  double peak_joint_speed = 0;         // rad/s
  double peak_joint_acceleration = 0;  // rad/s^2
  double root_speed = 0;               // m/s
};

// All frames of a motion.
std::vector<FrameDynamics> AnalyseMotion(Dynamics* dynamics,
                                         const ModelMotion& motion);

// Depth of SelfContacts in each frame, m.
std::vector<double> SelfDepths(Dynamics* dynamics, const ModelMotion& motion);

// max over t of after[t] - before[t], 0 if it never rises. Of equal lengths.
double LargestRise(const std::vector<double>& before,
                   const std::vector<double>& after);

v1::ClipQuality MeasureQuality(Dynamics* dynamics, const ModelMotion& motion,
                               const std::vector<FrameDynamics>& frames);

}  // namespace sinew::import

#endif  // SINEW_SIM_IMPORT_RETARGET_QUALITY_H_
