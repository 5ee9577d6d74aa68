#ifndef SINEW_SIM_MOTION_ROTATION_H_
#define SINEW_SIM_MOTION_ROTATION_H_

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace sinew::motion {

// Rotations as unit quaternions in double precision. In memory and in files
// quaternions are wxyz (MuJoCo's order); Eigen keeps xyzw inside, so arrays
// pass through FromWxyz and ToWxyz only. q and -q are the same rotation.
//
// Thread-safety: pure functions. Blocking: never. Errors: none; arguments
// must be finite, quaternions unit within rounding.

Eigen::Quaterniond FromWxyz(const double* wxyz);
Eigen::Quaterniond FromWxyz(const float* wxyz);
void ToWxyz(const Eigen::Quaterniond& rotation, double* wxyz);
void ToWxyz(const Eigen::Quaterniond& rotation, float* wxyz);

// Rotation vector (axis times angle, angle in [0, pi]) of a rotation, and its
// inverse.
Eigen::Vector3d Log(const Eigen::Quaterniond& rotation);
Eigen::Quaterniond Exp(const Eigen::Vector3d& rotation_vector);

// M in d(Log)/dt = M w for body-frame angular velocity w, at rotation vector
// `rotation_vector`, of angle less than 2 pi: the inverse of the right Jacobian
// of SO(3). Its transpose does the same for the parent's frame.
Eigen::Matrix3d InverseRightJacobian(const Eigen::Vector3d& rotation_vector);

// Angle of the rotation from a to b, [0, pi] rad; accurate near 0.
double AngleBetween(const Eigen::Quaterniond& a, const Eigen::Quaterniond& b);

// The short way from a (share 0) to b (share 1) at constant angular velocity.
Eigen::Quaterniond Slerp(const Eigen::Quaterniond& a,
                         const Eigen::Quaterniond& b, double share);

// Whichever of q and -q lies nearer to `reference`: keeps a series continuous.
Eigen::Quaterniond Near(const Eigen::Quaterniond& q,
                        const Eigen::Quaterniond& reference);

// World angular velocity (rad/s) of the middle one of three rotations of a
// frame in the world, spaced `dt` seconds: the mean of the velocities towards
// the neighbours; second-order accurate, no lag.
Eigen::Vector3d CentralAngularVelocity(const Eigen::Quaterniond& before,
                                       const Eigen::Quaterniond& middle,
                                       const Eigen::Quaterniond& after,
                                       double dt);

// Heading: angle (-pi, pi] of the twist about world z, that is of the turn
// about z nearest to the rotation. Smooth except upside down, so it holds for
// lying and pitching bodies too.
double Yaw(const Eigen::Quaterniond& rotation);

// The turn about world z by `yaw`.
Eigen::Quaterniond YawRotation(double yaw);

// `angle` plus the multiple of 2 pi that brings it nearest to `reference`.
double Unwrap(double angle, double reference);

}  // namespace sinew::motion

#endif  // SINEW_SIM_MOTION_ROTATION_H_
