#include "tools/render/following_camera.h"

#include <cmath>
#include <numbers>

namespace sinew::render {
namespace {

// Metres; a tall body with raised arms fits.
constexpr double kDistance = 3.8;
constexpr double kEyeLevel = 0.95;

// Yaw of the root, degrees: where its forward axis points over the ground.
double HeadingDegrees(absl::Span<const double> qpos) {
  const double w = qpos[3], x = qpos[4], y = qpos[5], z = qpos[6];
  return std::atan2(2 * (x * y + w * z), 1 - 2 * (y * y + z * z)) * 180 /
         std::numbers::pi;
}

}  // namespace

FollowingCamera::FollowingCamera(absl::Span<const double> first_pose)
    : azimuth_deg_(HeadingDegrees(first_pose) + 90) {}

Camera FollowingCamera::At(absl::Span<const double> pose) const {
  Camera camera;
  camera.target = {pose[0], pose[1], kEyeLevel};
  camera.distance = kDistance;
  camera.azimuth_deg = azimuth_deg_;
  return camera;
}

}  // namespace sinew::render
