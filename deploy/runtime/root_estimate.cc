#include "deploy/runtime/root_estimate.h"

#include <Eigen/Geometry>

namespace sinew::runtime {
namespace {

// Farther than any foot is from a root at standing height.
constexpr double kReach = 100;

struct LowestPoint {
  double distance = kReach;
  int body = 0;
  Eigen::Vector3d position = Eigen::Vector3d::Zero();
};

LowestPoint FindLowest(const character::Character& character, mjData* data) {
  LowestPoint lowest;
  for (size_t f = 0; f < character.foot_geoms().size(); ++f) {
    for (int geom : character.foot_geoms()[f]) {
      double from_to[6];
      const double distance =
          mj_geomDistance(character.model(), data, character.floor_geom(), geom,
                          kReach, from_to);
      if (distance >= lowest.distance) continue;
      lowest.distance = distance;
      lowest.body = character.foot_bodies()[f];
      lowest.position = Eigen::Vector3d(from_to[3], from_to[4], from_to[5]);
    }
  }
  return lowest;
}

}  // namespace

RootEstimate EstimateRoot(const character::Character& character, mjData* data) {
  const mjModel* model = character.model();
  double* root = data->qpos + character.root_qpos_address();
  root[2] = character.proto().standing_root_height();
  mj_kinematics(model, data);
  mj_comPos(model, data);
  mj_comVel(model, data);
  const LowestPoint lowest = FindLowest(character, data);
  root[2] -= lowest.distance;

  double velocity[6];  // rotational, then linear, of the foot's frame origin
  mj_objectVelocity(model, data, mjOBJ_XBODY, lowest.body, velocity,
                    /*flg_local=*/0);
  const Eigen::Vector3d rate(velocity[0], velocity[1], velocity[2]);
  const Eigen::Vector3d origin(data->xpos[3 * lowest.body],
                               data->xpos[3 * lowest.body + 1],
                               data->xpos[3 * lowest.body + 2]);
  const Eigen::Vector3d of_point =
      Eigen::Vector3d(velocity[3], velocity[4], velocity[5]) +
      rate.cross(lowest.position - origin);
  return {.height = root[2], .linear_velocity = -of_point};
}

}  // namespace sinew::runtime
