#ifndef SINEW_SIM_IMPORT_RETARGET_GROUND_POINTS_H_
#define SINEW_SIM_IMPORT_RETARGET_GROUND_POINTS_H_

#include <mujoco/mujoco.h>

#include <Eigen/Geometry>
#include <vector>

namespace sinew::import {

// A point of the model's surface that may touch the floor (z = 0): the ball of
// `radius` around `position` in the body's frame. Its lowest point is the
// contact point.
struct GroundPoint {
  int body;
  Eigen::Vector3d position;
  double radius;
};

// Points that between them contain the lowest point of every geom that collides
// with the floor: ends of capsules, centres of spheres, corners of boxes, rims
// of cylinders and ellipsoids (sampled), hull vertices of meshes (the extreme
// ones along sampled directions). Geoms of the world body are left out.
std::vector<GroundPoint> MakeGroundPoints(const mjModel& model, int floor_geom);

}  // namespace sinew::import

#endif  // SINEW_SIM_IMPORT_RETARGET_GROUND_POINTS_H_
