#ifndef SINEW_TOOLS_RENDER_OFFSCREEN_RENDERER_H_
#define SINEW_TOOLS_RENDER_OFFSCREEN_RENDERER_H_

#include <mujoco/mujoco.h>

#include <array>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/types/span.h"
#include "sim/character/character.h"
#include "sim/character/model_ptr.h"
#include "tools/render/gl_context.h"
#include "tools/render/image.h"

namespace sinew::render {

// Where the eye is: `distance` metres from the point `target` (world, z up),
// looking along `azimuth_deg` (0: +x, 90: +y) tilted up by `elevation_deg`.
struct Camera {
  std::array<double, 3> target = {0, 0, 0.9};
  double distance = 3.2;
  double azimuth_deg = 90;
  double elevation_deg = -8;
};

// The body in one pose.
struct Figure {
  absl::Span<const double> qpos;  // [nq]
  // Unset: its own colours. Else one colour for the whole body (red, green,
  // blue, opacity in [0, 1]), as for a ghost of the reference.
  std::optional<std::array<float, 4>> colour;
};

// A model to be seen: the character's with its visual geoms and a scene, where
// its files are found by name and fit; else a copy of its physics model.
character::ModelPtr PictureModel(const character::Character& character);

// Draws a model in given poses, without window or GPU.
//
// Thread-safety: one thread at a time, always the same. Ownership: owns model,
// GL context and buffers. Blocking: Create ~0.3 s, Render ~0.1 s for 640 x
// 480. Errors: UNAVAILABLE without OpenGL (GlContext); INVALID_ARGUMENT for
// sizes outside [16, 4096] and qpos of another length or not finite.
class OffscreenRenderer {
 public:
  // Pictures of width x height pixels.
  static absl::StatusOr<std::unique_ptr<OffscreenRenderer>> Create(
      character::ModelPtr model, int width, int height);
  ~OffscreenRenderer();
  OffscreenRenderer(const OffscreenRenderer&) = delete;
  OffscreenRenderer& operator=(const OffscreenRenderer&) = delete;

  int width() const { return width_; }
  int height() const { return height_; }
  const mjModel& model() const { return *model_; }

  // One picture of all figures (at least one) in the same world. `caption`, if
  // any, is written into the top left corner.
  absl::StatusOr<Image> Render(absl::Span<const Figure> figures,
                               const Camera& camera,
                               const std::string& caption = "");

 private:
  OffscreenRenderer(character::ModelPtr model,
                    std::unique_ptr<GlContext> context, int width, int height);
  absl::Status CheckPose(absl::Span<const double> qpos) const;
  void AddFigure(const Figure& figure, bool first, mjvCamera* camera);
  Image ReadPixels();

  character::ModelPtr model_;
  character::DataPtr data_;
  std::unique_ptr<GlContext> context_;
  int width_, height_;
  mjvScene scene_;
  mjvOption options_;
  mjrContext gpu_;
};

}  // namespace sinew::render

#endif  // SINEW_TOOLS_RENDER_OFFSCREEN_RENDERER_H_
