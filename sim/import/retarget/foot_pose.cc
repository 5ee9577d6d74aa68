#include "sim/import/retarget/foot_pose.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace sinew::import {
namespace {

using Eigen::Quaterniond;
using Eigen::Vector3d;

// A foot that stands: slower than this share of a leg per second, and no
// higher than this share of a leg over where it usually is when low.
constexpr double kStillSpeed = 0.3;
constexpr double kLowHeight = 0.025;
constexpr double kLowShare = 0.2;
// A sole further from the standing pose's than this is no standing foot, rad.
constexpr double kMostTilt = 0.6;
// Frames whose sole differs by more from the mean are left out, rad.
constexpr double kSpread = 0.15;
constexpr size_t kLeastFrames = 3;

double LegLength(const RoleTrack& track, const std::string& side) {
  const Vector3d hip = track.standing[track.Find(side + "hip")];
  const Vector3d knee = track.standing[track.Find(side + "knee")];
  const Vector3d ankle = track.standing[track.Find(side + "ankle")];
  return (knee - hip).norm() + (ankle - knee).norm();
}

double Angle(const Vector3d& a, const Vector3d& b) {
  return std::atan2(a.cross(b).norm(), a.dot(b));
}

// World "up" as the foot sees it, in every frame in which it stands.
std::vector<Vector3d> StandingUps(const RoleTrack& track,
                                  const std::string& side) {
  const int ankle = track.Find(side + "ankle");
  const double leg = LegLength(track, side);
  std::vector<double> heights;
  for (const auto& frame : track.position) heights.push_back(frame[ankle].z());
  std::vector<double> sorted = heights;
  const auto low =
      sorted.begin() + static_cast<std::ptrdiff_t>(
                           kLowShare * static_cast<double>(sorted.size()));
  std::nth_element(sorted.begin(), low, sorted.end());
  const double highest = *low + kLowHeight * leg;
  std::vector<Vector3d> ups;
  for (int t = 1; t + 1 < track.frames(); ++t) {
    const Vector3d change =
        track.position[t + 1][ankle] - track.position[t - 1][ankle];
    const double speed = change.norm() * track.rate / 2;
    if (heights[t] > highest || speed > kStillSpeed * leg) continue;
    const Vector3d up =
        track.rotation[t][ankle].conjugate() * Vector3d::UnitZ();
    if (Angle(up, Vector3d::UnitZ()) < kMostTilt) ups.push_back(up);
  }
  return ups;
}

// Mean direction, the second time of those near the first.
Vector3d RobustMean(const std::vector<Vector3d>& directions) {
  Vector3d mean = Vector3d::Zero();
  for (const Vector3d& d : directions) mean += d;
  Vector3d close = Vector3d::Zero();
  for (const Vector3d& d : directions) {
    if (Angle(d, mean) < kSpread) close += d;
  }
  return (close.norm() > 0 ? close : mean).normalized();
}

}  // namespace

Quaterniond FootPose(const RoleTrack& track, const std::string& side) {
  const std::vector<Vector3d> ups = StandingUps(track, side);
  const Vector3d up =
      ups.size() < kLeastFrames ? Vector3d::UnitZ() : RobustMean(ups);
  const int toe = track.Find(side + "toe");
  Vector3d forward = Vector3d::UnitX();
  if (toe >= 0) {
    forward = track.standing[toe] - track.standing[track.Find(side + "ankle")];
  }
  forward -= forward.dot(up) * up;
  if (forward.norm() < 1e-6 || forward.x() < 0) {
    forward = Vector3d::UnitX() - up.x() * up;
  }
  forward.normalize();
  Eigen::Matrix3d basis;
  basis << forward, up.cross(forward), up;
  return Quaterniond(basis);
}

}  // namespace sinew::import
