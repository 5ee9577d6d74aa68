#include "sim/motion/rotation.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace sinew::motion {
namespace {

using Eigen::Quaterniond;
using Eigen::Vector3d;

// Below this half angle sin(x)/x is 1 - x^2/6 in double precision.
constexpr double kSmallAngle = 1e-5;

}  // namespace

Quaterniond FromWxyz(const double* wxyz) {
  return Quaterniond(wxyz[0], wxyz[1], wxyz[2], wxyz[3]);
}

Quaterniond FromWxyz(const float* wxyz) {
  return Quaterniond(wxyz[0], wxyz[1], wxyz[2], wxyz[3]);
}

void ToWxyz(const Quaterniond& rotation, double* wxyz) {
  wxyz[0] = rotation.w();
  wxyz[1] = rotation.x();
  wxyz[2] = rotation.y();
  wxyz[3] = rotation.z();
}

void ToWxyz(const Quaterniond& rotation, float* wxyz) {
  wxyz[0] = static_cast<float>(rotation.w());
  wxyz[1] = static_cast<float>(rotation.x());
  wxyz[2] = static_cast<float>(rotation.y());
  wxyz[3] = static_cast<float>(rotation.z());
}

Vector3d Log(const Quaterniond& rotation) {
  const double sign = rotation.w() < 0 ? -1 : 1;
  const Vector3d vector = sign * rotation.vec();
  const double sine = vector.norm();
  const double cosine = sign * rotation.w();
  if (sine < kSmallAngle) return 2 / cosine * vector;
  return 2 * std::atan2(sine, cosine) / sine * vector;
}

Quaterniond Exp(const Vector3d& rotation_vector) {
  const double half = rotation_vector.norm() / 2;
  const double factor = half < kSmallAngle ? 0.5 * (1 - half * half / 6)
                                           : std::sin(half) / (2 * half);
  Quaterniond q;
  q.w() = std::cos(half);
  q.vec() = factor * rotation_vector;
  return q.normalized();
}

Eigen::Matrix3d InverseRightJacobian(const Vector3d& r) {
  const double angle = r.norm();
  Eigen::Matrix3d cross;
  cross << 0, -r.z(), r.y(), r.z(), 0, -r.x(), -r.y(), r.x(), 0;
  // The last factor tends to 1/12 as the angle tends to 0.
  const double factor =
      angle < 1e-3 ? 1.0 / 12
                   : 1 / (angle * angle) -
                         (1 + std::cos(angle)) / (2 * angle * std::sin(angle));
  return Eigen::Matrix3d::Identity() + 0.5 * cross + factor * cross * cross;
}

double AngleBetween(const Quaterniond& a, const Quaterniond& b) {
  const Quaterniond between = a.conjugate() * b;
  return 2 * std::atan2(between.vec().norm(), std::abs(between.w()));
}

Quaterniond Slerp(const Quaterniond& a, const Quaterniond& b, double share) {
  return (a * Exp(share * Log(a.conjugate() * b))).normalized();
}

Quaterniond Near(const Quaterniond& q, const Quaterniond& reference) {
  return q.dot(reference) < 0 ? Quaterniond(-q.coeffs()) : q;
}

Vector3d CentralAngularVelocity(const Quaterniond& before,
                                const Quaterniond& middle,
                                const Quaterniond& after, double dt) {
  const Vector3d forward = Log(middle.conjugate() * after);
  const Vector3d backward = Log(middle.conjugate() * before);
  return middle * ((forward - backward) / (2 * dt));
}

double Yaw(const Quaterniond& rotation) {
  return std::remainder(2 * std::atan2(rotation.z(), rotation.w()),
                        2 * std::numbers::pi);
}

Quaterniond YawRotation(double yaw) {
  return Quaterniond(std::cos(yaw / 2), 0, 0, std::sin(yaw / 2));
}

double Unwrap(double angle, double reference) {
  return reference + std::remainder(angle - reference, 2 * std::numbers::pi);
}

}  // namespace sinew::motion
