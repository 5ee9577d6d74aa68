#ifndef SINEW_TOOLS_MOTION_REPORT_BODY_SHAPES_H_
#define SINEW_TOOLS_MOTION_REPORT_BODY_SHAPES_H_

#include <mujoco/mujoco.h>

#include "nlohmann/json.hpp"

namespace sinew::motion_report {

// What a viewer draws of a character, in simple shapes:
//
//   [{"name", "shapes": [{"type": "sphere" | "capsule" | "cylinder" | "box" |
//                                 "ellipsoid",
//                         "size": [3], "position": [3], "rotation": [4]}]}]
//
// one entry per body but the world, in model order, as the columns of a motion
// library. Sizes are MuJoCo's (half extents; radius and half length along z),
// metres; position and rotation (wxyz) in the body's frame. Meshes become
// capsules or boxes around them. A body without geoms is drawn as thin
// capsules to the bodies that hang on it. Pure.
nlohmann::json BodyShapes(const mjModel& model);

}  // namespace sinew::motion_report

#endif  // SINEW_TOOLS_MOTION_REPORT_BODY_SHAPES_H_
