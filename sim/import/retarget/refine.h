#ifndef SINEW_SIM_IMPORT_RETARGET_REFINE_H_
#define SINEW_SIM_IMPORT_RETARGET_REFINE_H_

#include <vector>

#include "common/stop.h"
#include "sim/import/retarget/contact_fit.h"
#include "sim/import/retarget/dynamics.h"
#include "sim/import/retarget/model_motion.h"

namespace sinew::import {

// What a refined motion is weighed by. Each number multiplies a residual whose
// squares are summed over frames.
struct RefineOptions {
  // Root force in body weights (torque: kTorqueArm times that) which contact
  // cannot explain.
  double physics = 1;
  // A joint torque at its limit, of the above. Three times what the fit of
  // forces alone takes: with less, single frames of get-ups ask for ten times a
  // limit; with this for three, at no higher residual.
  double torque = 3 * kJointWeight;
  // Distance from the motion as it came: hinges and root rotation per rad, root
  // position per m along the floor and up.
  double joint = 0.5;
  double rotation = 1;
  double position = 2;
  double height = 1;
  // Second differences per frame^2, hinges and root rotation per rad, root
  // position per m: of the motion, and of what is changed about it.
  double acceleration = 0.1;
  double change_acceleration = 0.5;
  // Bearing points: height and horizontal move per frame, per m.
  double contact_height = 10;
  double contact_slip = 10;
  // Points below the floor per m; hinges beyond a limit per rad.
  double penetration = 20;
  double limit = 5;
  // Bodies deeper in one another than any two are in the motion as it came, in
  // that frame, per m.
  double self = 20;
  // Gauss-Newton steps at most, of each window. A step that lowers the cost by
  // less than the share `converged` is the last one.
  int iterations = 60;
  double converged = 1e-3;
  // Longer clips are refined in windows of so many frames, one after the other.
  // The next window begins so many frames before the end of the last, and
  // continues what lies before them as it is: `overlap` is how far the open end
  // of a window is wrong. Precondition: 2 * overlap + 2 < window.
  int window = 600;
  int overlap = 60;
  // On a request to stop what is left is not refined.
  StopToken stop = {};
};

// Changes a motion as little as it takes to make it physical: Gauss-Newton over
// all coordinates of a window of frames on the terms above. The floor's forces
// are no unknowns: each frame takes the best ones (FitContacts) and the root
// residual's metric accounts for their following along (variable projection).
//   for each window, first without the term of bodies in one another, then,
//   where they are, with it:
//     repeat: note which points may bear; linearise every term; solve for all
//     frames at once; accept if the sum of squares fell, else raise the
//     damping.
// `bearing` [frames][points] from FindBearingPoints. Hinges end within their
// limits. Deterministic.
//
// Thread-safety: as Dynamics. Blocking: a few milliseconds per frame; memory
// beside the motions is that of one window. Errors: none; motions of fewer than
// 3 frames come back as they are.
ModelMotion RefineMotion(Dynamics* dynamics,
                         const std::vector<std::vector<bool>>& bearing,
                         const ModelMotion& motion,
                         const RefineOptions& options = {});

}  // namespace sinew::import

#endif  // SINEW_SIM_IMPORT_RETARGET_REFINE_H_
