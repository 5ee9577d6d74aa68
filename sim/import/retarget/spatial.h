#ifndef SINEW_SIM_IMPORT_RETARGET_SPATIAL_H_
#define SINEW_SIM_IMPORT_RETARGET_SPATIAL_H_

#include <Eigen/Dense>

namespace sinew::import {

// Spatial vectors as MuJoCo's com-based quantities have them (cdof, cvel,
// cinert): rotation first, world axes, about one point that all bodies share.
// Motions are (angular velocity, velocity of the body at the point), forces are
// (moment about the point, force).
//
// Thread-safety: pure functions.
using Vector6 = Eigen::Matrix<double, 6, 1>;
using Matrix6 = Eigen::Matrix<double, 6, 6>;

inline Vector6 MakeVector6(const Eigen::Vector3d& rotation,
                           const Eigen::Vector3d& translation) {
  Vector6 result;
  result << rotation, translation;
  return result;
}

inline Eigen::Map<const Vector6> SpatialAt(const double* vectors, int index) {
  return Eigen::Map<const Vector6>(vectors + 6 * index);
}

// S with S x = v cross x.
inline Eigen::Matrix3d Skew(const Eigen::Vector3d& v) {
  Eigen::Matrix3d skew;
  skew << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return skew;
}

// Rate of change of a motion vector m that moves with v.
inline Vector6 CrossMotion(const Vector6& v, const Vector6& m) {
  const Eigen::Vector3d turn = v.head<3>();
  const Eigen::Vector3d axis = m.head<3>();
  return MakeVector6(turn.cross(axis),
                     turn.cross(m.tail<3>()) + v.tail<3>().cross(axis));
}

// Rate of change of a force vector f that moves with v.
inline Vector6 CrossForce(const Vector6& v, const Vector6& f) {
  const Eigen::Vector3d turn = v.head<3>();
  const Eigen::Vector3d force = f.tail<3>();
  return MakeVector6(turn.cross(f.head<3>()) + v.tail<3>().cross(force),
                     turn.cross(force));
}

}  // namespace sinew::import

#endif  // SINEW_SIM_IMPORT_RETARGET_SPATIAL_H_
