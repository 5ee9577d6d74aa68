#ifndef SINEW_SIM_IMPORT_RETARGET_FOOT_POSE_H_
#define SINEW_SIM_IMPORT_RETARGET_FOOT_POSE_H_

#include <Eigen/Geometry>
#include <string>

#include "sim/import/retarget/role_track.h"

namespace sinew::import {

// How the source holds a foot in its standing pose: the turn from a foot with a
// level sole that points along +x. Rest poses spread the legs or point the
// toes; what is level is seen where the clip's foot stands still and low.
// `side` is "left_" or "right_". Without such frames the standing pose's sole
// is taken to be level.
Eigen::Quaterniond FootPose(const RoleTrack& track, const std::string& side);

}  // namespace sinew::import

#endif  // SINEW_SIM_IMPORT_RETARGET_FOOT_POSE_H_
