#ifndef SINEW_SIM_IMPORT_RETARGET_JOINT_FIT_H_
#define SINEW_SIM_IMPORT_RETARGET_JOINT_FIT_H_

#include <Eigen/Dense>
#include <vector>

#include "sim/import/retarget/hinge_chain.h"

namespace sinew::import {

// Angles of a chain's hinges for a series of rotations (child in parent), one
// per frame, continuous over time:
//   1. every frame: all solutions of the decomposition;
//   2. the shortest path through them over the clip (change of angles, plus
//      cost beyond limits);
//   3. Gauss-Newton over the whole clip on rotation error, smoothness and
//      limits, from which singular frames take their neighbours' angles;
//   4. clamping to the limits.
// `cut`, if given, grows by the number of angles at a limit that the targets
// exceed by more than a degree. `loops`: the last frame is followed by the
// first. Returns [frames] of [k] (angles as in HingeChain). Precondition: at
// least two targets.
std::vector<Eigen::VectorXd> FitJoints(
    const HingeChain& chain, const std::vector<Eigen::Quaterniond>& targets,
    bool loops, int* cut = nullptr);

}  // namespace sinew::import

#endif  // SINEW_SIM_IMPORT_RETARGET_JOINT_FIT_H_
