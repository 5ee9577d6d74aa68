#include "tools/render/pictures.h"

#include <memory>

#include "common/status_macros.h"
#include "tools/render/image.h"

namespace sinew::render {

absl::StatusOr<std::string> RenderPose(const character::Character& character,
                                       absl::Span<const double> qpos,
                                       const Camera& camera, PictureSize size) {
  SINEW_ASSIGN_OR_RETURN(const std::unique_ptr<OffscreenRenderer> renderer,
                         OffscreenRenderer::Create(PictureModel(character),
                                                   size.width, size.height));
  SINEW_ASSIGN_OR_RETURN(const Image image,
                         renderer->Render({{{qpos, std::nullopt}}}, camera));
  return EncodePng(image);
}

absl::StatusOr<std::string> RenderFilmStrip(
    const character::Character& character, const PoseRows& reference,
    const PoseRows& simulated, int columns, double frames_per_second,
    PictureSize size) {
  SINEW_ASSIGN_OR_RETURN(const std::unique_ptr<OffscreenRenderer> renderer,
                         OffscreenRenderer::Create(PictureModel(character),
                                                   size.width, size.height));
  SINEW_ASSIGN_OR_RETURN(
      const Image strip,
      FilmStrip(*renderer, reference, simulated, columns, frames_per_second));
  return EncodePng(strip);
}

}  // namespace sinew::render
