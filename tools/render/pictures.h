#ifndef SINEW_TOOLS_RENDER_PICTURES_H_
#define SINEW_TOOLS_RENDER_PICTURES_H_

#include <string>

#include "absl/status/statusor.h"
#include "absl/types/span.h"
#include "sim/character/character.h"
#include "tools/render/film_strip.h"
#include "tools/render/offscreen_renderer.h"

namespace sinew::render {

// Whole pictures as the bytes of PNG files, for reports. Each call makes and
// drops a renderer (~0.3 s); many pictures share an OffscreenRenderer instead.
// Errors: those of OffscreenRenderer and FilmStrip.

struct PictureSize {
  int width = 480;
  int height = 480;
};

// The character in one pose, qpos [nq].
absl::StatusOr<std::string> RenderPose(const character::Character& character,
                                       absl::Span<const double> qpos,
                                       const Camera& camera,
                                       PictureSize size = {});

// See FilmStrip; `size` is that of one of the pictures.
absl::StatusOr<std::string> RenderFilmStrip(
    const character::Character& character, const PoseRows& reference,
    const PoseRows& simulated, int columns, double frames_per_second,
    PictureSize size = {.width = 240, .height = 360});

}  // namespace sinew::render

#endif  // SINEW_TOOLS_RENDER_PICTURES_H_
