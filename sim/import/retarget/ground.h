#ifndef SINEW_SIM_IMPORT_RETARGET_GROUND_H_
#define SINEW_SIM_IMPORT_RETARGET_GROUND_H_

#include <optional>
#include <vector>

#include "sim/import/retarget/dynamics.h"
#include "sim/import/retarget/model_motion.h"

namespace sinew::import {

// Evidence of flight in a frame, from three measurements of its lowest point
// and its centre of mass, each mapped linearly to [-1, 1] between the values
// that say "carried" and "flying":
//   height of the lowest point over the ground, counted twice: 0 to 0.08 m;
//   speed of the material point there: 0 to 1.6 m/s;
//   support (a_z + g) / g of the centre of mass, over a few frames: 1 to 0.
// Flying needs more than kFlightBias in all; changing one's mind costs
// kFlightChange. Feet and any other body count alike, so lying, crawling and
// rolling bodies are carried.
inline constexpr double kFlightHeight = 0.08;
inline constexpr double kFlightSpeed = 1.6;
inline constexpr double kFlightBias = 0.5;
inline constexpr double kFlightChange = 1.0;

// A point that bears moves slower than this, m/s.
inline constexpr double kContactSpeed = 0.6;
// Stiffness of the height correction against second differences, per frame^4:
// it follows changes over about 2 pi stiffness^(1/4) = 12 frames.
inline constexpr double kGroundStiffness = 16;

// The value that `share` of all are no greater than, rounded down to one of
// them. Precondition: there is one.
double Percentile(std::vector<double> values, double share);

// Which frames the floor carries: the cheapest series of "carried" and "flying"
// under the evidence. `ground` is the height of the floor in the motion's
// coordinates; unset: the 30th percentile of the lowest points. At least one
// frame is supported.
std::vector<bool> FindSupport(Dynamics* dynamics, const ModelMotion& motion,
                              std::optional<double> ground = std::nullopt);

// Moves the root up or down so that the lowest point lies on the floor in
// supported frames: a smoothing spline through minus the lowest points' heights
// there, which also bridges flights. Heights are not changed otherwise.
void CalibrateGround(Dynamics* dynamics, const std::vector<bool>& supported,
                     ModelMotion* motion);

// Brings a motion of any height to the floor: FindSupport, CalibrateGround,
// both again on the result, then MakeFlightsBallistic. Returns the support.
std::vector<bool> PlaceOnFloor(Dynamics* dynamics, ModelMotion* motion);

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

#endif  // SINEW_SIM_IMPORT_RETARGET_GROUND_H_
