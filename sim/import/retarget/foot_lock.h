#ifndef SINEW_SIM_IMPORT_RETARGET_FOOT_LOCK_H_
#define SINEW_SIM_IMPORT_RETARGET_FOOT_LOCK_H_

#include <Eigen/Geometry>
#include <vector>

#include "sim/import/retarget/dynamics.h"
#include "sim/import/retarget/model_motion.h"

namespace sinew::import {

// A point of a sole that stands in a frame.
struct Lock {
  int point;  // index into ImportModel::points
  // Where it stands; unlocked where the foot slides on purpose: height only.
  Eigen::Vector2d place;
  bool slides = false;
};

// A point of a sole lower than this and slower than that stands, m and m/s,
// for at least kLeastStand frames; stands with gaps of up to kLargestGap frames
// are one.
inline constexpr double kLockHeight = 0.035;
inline constexpr double kLockSpeed = 0.5;
inline constexpr int kLeastStand = 3;
inline constexpr int kLargestGap = 2;
// A stand during which the point moves further than this from its mean place,
// m, is a slide.
inline constexpr double kLeastSlide = 0.1;

// Points that stand, per frame: of each foot the (at most four) corners of its
// sole. A point's place is its mean over the stand, slow frames weighing more;
// over the seam of a loop it moves with the cycle. `supported` from FindSupport
// of the motion, which stands on the floor.
std::vector<std::vector<Lock>> FindLocks(const std::vector<bool>& supported,
                                         const ModelMotion& motion,
                                         Dynamics* dynamics);

}  // namespace sinew::import

#endif  // SINEW_SIM_IMPORT_RETARGET_FOOT_LOCK_H_
