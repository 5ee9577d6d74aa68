#include "sim/import/retarget/zero_pose.h"

#include "sim/motion/rotation.h"

namespace sinew::import {

using Eigen::Matrix3d;
using Eigen::Quaterniond;
using Eigen::Vector3d;

ZeroPose::ZeroPose(const mjModel& model, int root)
    : position(model.nbody, Vector3d::Zero()),
      rotation(model.nbody, Quaterniond::Identity()) {
  for (int b = root + 1; b < model.nbody; ++b) {
    const int parent = model.body_parentid[b];
    position[b] =
        position[parent] +
        rotation[parent] * Eigen::Map<const Vector3d>(model.body_pos + 3 * b);
    rotation[b] = rotation[parent] * motion::FromWxyz(model.body_quat + 4 * b);
  }
}

Vector3d ZeroPose::Centre(const mjModel& model,
                          const std::vector<int>& joints) const {
  // Least squares over distances to the axes, lightly held at their anchors.
  constexpr double kHold = 1e-3;
  Matrix3d matrix = Matrix3d::Zero();
  Vector3d right = Vector3d::Zero();
  for (const int joint : joints) {
    const int body = model.jnt_bodyid[joint];
    const Vector3d anchor =
        position[body] +
        rotation[body] * Eigen::Map<const Vector3d>(model.jnt_pos + 3 * joint);
    const Vector3d axis =
        rotation[body] * Eigen::Map<const Vector3d>(model.jnt_axis + 3 * joint);
    const Matrix3d across = Matrix3d::Identity() - axis * axis.transpose() +
                            kHold * Matrix3d::Identity();
    matrix += across;
    right += across * anchor;
  }
  return matrix.ldlt().solve(right);
}

}  // namespace sinew::import
