#ifndef SINEW_SIM_IMPORT_RETARGET_POSE_FIT_H_
#define SINEW_SIM_IMPORT_RETARGET_POSE_FIT_H_

#include <vector>

#include "common/stop.h"
#include "sim/import/retarget/body_map.h"
#include "sim/import/retarget/dynamics.h"
#include "sim/import/retarget/foot_lock.h"
#include "sim/import/retarget/model_motion.h"
#include "sim/import/retarget/scaled_source.h"

namespace sinew::import {

// What a fitted pose is weighed by. Each number multiplies a residual whose
// squares are summed over frames.
struct PoseFitOptions {
  // Distance of a role's point from the scaled source, per m: ends of limbs,
  // other joints.
  double end = 4;
  double joint = 2;
  // Turn of a mapped body from the source's, per rad; less for limbs, whose
  // directions are given by their points.
  double rotation = 0.5;
  double limb_rotation = 0.15;
  // Distance from the motion as it came: hinges and root rotation per rad, root
  // position per m.
  double hinge = 0.1;
  double root_rotation = 0.5;
  double root_position = 1;
  // Second differences per frame^2 of what is changed: hinges and root rotation
  // per rad, root position per m.
  double hinge_change = 2;
  double root_change = 6;
  // Points of soles that stand: off their place along the floor, and off the
  // floor; points below the floor; all per m.
  double lock = 25;
  double height = 12;
  double penetration = 20;
  // Hinges beyond a limit per rad; bodies in one another per m.
  double limit = 5;
  double self = 8;
  // Gauss-Newton steps.
  int iterations = 4;
  // Longer clips are fitted in windows of so many frames, each for itself; the
  // next one begins so many frames before the end of the last, and over these
  // what the one changes goes over into what the other does. A last window that
  // would be shorter than an overlap more is a part of the one before.
  // Precondition: 1 <= overlap, 2 * overlap < window.
  int window = 3000;
  int overlap = 60;
  // On a request to stop what is left is not fitted.
  StopToken stop = {};
};

// Fits poses to the scaled source over a whole clip: the ends of limbs, joints
// and rotations are where the source has them, feet that stand do not move and
// lie on the floor, nothing sinks into the floor or into the body, hinges keep
// their limits; what that changes is smooth over time. Gauss-Newton on the
// terms above with MuJoCo's Jacobians and a block-banded solve. Memory beside
// the motions is that of one window: 48 nv^2 bytes a frame, 55 kB for the
// humanoid's 34 velocities.
//
// `motion` (on the floor) is where it starts and what `wanted` and `locks` were
// made from. Hinges end within their limits.
ModelMotion FitPoses(const RoleTrack& track, const BodyMap& map,
                     const ScaledSource& wanted,
                     const std::vector<std::vector<Lock>>& locks,
                     const ModelMotion& motion, Dynamics* dynamics,
                     const PoseFitOptions& options = {});

}  // namespace sinew::import

#endif  // SINEW_SIM_IMPORT_RETARGET_POSE_FIT_H_
