#ifndef SINEW_SIM_IMPORT_GROUND_H_
#define SINEW_SIM_IMPORT_GROUND_H_

#include <vector>

#include "sim/import/dynamics.h"
#include "sim/import/model_motion.h"

namespace sinew::import {

// Thresholds of "supported by the floor", for feet and any other body alike.

// A point that bears moves slower than this, m/s.
inline constexpr double kContactSpeed = 0.6;
// The centre of mass of a supported body falls with less than this share of
// gravity less than free fall: (a_z + g) / g of flight is 0, of standing 1.
inline constexpr double kLeastSupport = 0.3;
// A supported frame's lowest point lies at most this far above the median of
// the candidates, m: clips float, but not by more.
inline constexpr double kGroundBand = 0.15;
// Stiffness of the height correction against second differences, per frame^4:
// it follows changes over about 2 pi stiffness^(1/4) = 12 frames.
inline constexpr double kGroundStiffness = 16;

// Which frames the floor carries.
//   1. a frame is a candidate if its lowest point is slow and the centre of
//      mass is not in free fall; those far above the others are dropped;
//   2. single frames between two of the other kind are flipped.
// At least one frame is supported: the one with the lowest point, if need be.
std::vector<bool> FindSupport(Dynamics* dynamics, const ModelMotion& motion);

// Moves the root up or down so that the lowest point lies on the floor in
// supported frames: a smoothing spline through minus the lowest points' heights
// there, which also bridges flights. Heights are not changed otherwise.
void CalibrateGround(Dynamics* dynamics, const std::vector<bool>& supported,
                     ModelMotion* motion);

// Makes flights (runs of two or more unsupported frames between supported
// ones) ballistic: the centre of mass follows the parabola (gravity of the
// model) from take-off to landing, the body is carried along.
void MakeFlightsBallistic(Dynamics* dynamics,
                          const std::vector<bool>& supported,
                          ModelMotion* motion);

// [frames][points]: points that bear: low (kContactMargin) and slow, in a
// supported frame.
std::vector<std::vector<bool>> FindBearingPoints(
    Dynamics* dynamics, const std::vector<bool>& supported,
    const ModelMotion& motion);

}  // namespace sinew::import

#endif  // SINEW_SIM_IMPORT_GROUND_H_
