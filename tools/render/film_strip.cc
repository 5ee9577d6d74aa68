#include "tools/render/film_strip.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "common/status_macros.h"

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

Camera Following(absl::Span<const double> reference, double azimuth_deg) {
  Camera camera;
  camera.target = {reference[0], reference[1], kEyeLevel};
  camera.distance = kDistance;
  camera.azimuth_deg = azimuth_deg;
  return camera;
}

absl::Status Check(const OffscreenRenderer& renderer, const PoseRows& rows,
                   const char* which) {
  if (rows.nq != renderer.model().nq || rows.frames() < 1) {
    return absl::InvalidArgumentError(absl::StrCat(
        "film strip: ", which, ": expected frames of ", renderer.model().nq,
        " numbers, found ", rows.frames(), " of ", rows.nq));
  }
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<Image> FilmStrip(OffscreenRenderer& renderer,
                                const PoseRows& reference,
                                const PoseRows& simulated, int columns,
                                double frames_per_second) {
  SINEW_RETURN_IF_ERROR(Check(renderer, reference, "reference"));
  SINEW_RETURN_IF_ERROR(Check(renderer, simulated, "simulated"));
  if (columns < 1) {
    return absl::InvalidArgumentError(absl::StrCat(
        "film strip: columns: expected at least 1, found ", columns));
  }
  const int last = std::min(reference.frames(), simulated.frames()) - 1;
  const double azimuth = HeadingDegrees(reference.row(0)) + 90;
  Image strip(columns * renderer.width(), 2 * renderer.height());
  for (int column = 0; column < columns; ++column) {
    const int frame =
        columns == 1 ? 0
                     : static_cast<int>(std::lround(static_cast<double>(last) *
                                                    column / (columns - 1)));
    const Camera camera = Following(reference.row(frame), azimuth);
    const std::string caption =
        frames_per_second > 0
            ? absl::StrFormat("%.2f s", frame / frames_per_second)
            : "";
    SINEW_ASSIGN_OR_RETURN(
        const Image above,
        renderer.Render({{{reference.row(frame), std::nullopt}}}, camera,
                        caption));
    SINEW_ASSIGN_OR_RETURN(
        const Image below,
        renderer.Render({{{simulated.row(frame), std::nullopt}}}, camera));
    Paste(above, column * renderer.width(), 0, &strip);
    Paste(below, column * renderer.width(), renderer.height(), &strip);
  }
  return strip;
}

}  // namespace sinew::render
