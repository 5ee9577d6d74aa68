#ifndef SINEW_SIM_IMPORT_RETARGET_SCALED_SOURCE_H_
#define SINEW_SIM_IMPORT_RETARGET_SCALED_SOURCE_H_

#include <Eigen/Geometry>
#include <vector>

#include "proto/sinew/v1/motion.pb.h"
#include "sim/import/retarget/body_map.h"
#include "sim/import/retarget/dynamics.h"
#include "sim/import/retarget/model_motion.h"
#include "sim/import/retarget/role_track.h"

namespace sinew::import {

// The source's skeleton at the model's size, where a motion has it: trunk as
// the model's, limbs in the source's directions with the model's lengths, so
// that straight limbs stay straight; but hands where the source's are from its
// hips, scaled with the legs (or as near to there as arms reach), as what they
// do they do to each other and to the body, with elbows bent to them; roles
// that the model lacks beside their parents, scaled with the legs.
// [frames][roles], world.
using ScaledSource = std::vector<std::vector<Eigen::Vector3d>>;

ScaledSource ScaleSource(const RoleTrack& track, const BodyMap& map,
                         const ModelMotion& motion, Dynamics* dynamics);

// World positions of BodyMap::points in the pose of `dynamics`.
Eigen::Vector3d PointPlace(const BodyMap& map, const RolePoint& point,
                           const Dynamics& dynamics);

// Fills retarget_error_m and retarget_errors: distances between the points of
// `motion` and the scaled source.
void MeasureRetargetError(const RoleTrack& track, const BodyMap& map,
                          const ScaledSource& wanted, const ModelMotion& motion,
                          Dynamics* dynamics, v1::ClipQuality* quality);

}  // namespace sinew::import

#endif  // SINEW_SIM_IMPORT_RETARGET_SCALED_SOURCE_H_
