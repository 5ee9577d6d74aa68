#ifndef SINEW_TOOLS_RENDER_FILM_STRIP_H_
#define SINEW_TOOLS_RENDER_FILM_STRIP_H_

#include <string>

#include "absl/status/statusor.h"
#include "absl/types/span.h"
#include "tools/render/image.h"
#include "tools/render/offscreen_renderer.h"

namespace sinew::render {

// Poses over time, row-major [frames, nq].
struct PoseRows {
  absl::Span<const double> qpos;
  int nq = 0;

  int frames() const {
    return nq == 0 ? 0 : static_cast<int>(qpos.size()) / nq;
  }
  absl::Span<const double> row(int frame) const {
    return qpos.subspan(static_cast<size_t>(frame) * nq, nq);
  }
};

// A strip of pictures, each of the renderer's size: the reference above, the
// simulation below, `columns` moments evenly spaced from the first frame to the
// last that both have. The camera stands to the right of where the reference
// first faces and follows the reference's root over the ground, alike for both
// rows, so that drifting apart is seen. With `frames_per_second` > 0 each
// picture of the upper row shows its time.
// INVALID_ARGUMENT: no frames, another nq than the model's, columns < 1.
absl::StatusOr<Image> FilmStrip(OffscreenRenderer& renderer,
                                const PoseRows& reference,
                                const PoseRows& simulated, int columns,
                                double frames_per_second = 0);

// The same of the reference alone: one row.
absl::StatusOr<Image> ReferenceStrip(OffscreenRenderer& renderer,
                                     const PoseRows& reference, int columns,
                                     double frames_per_second = 0);

// One moment of a film of the reference alone, seen as in a strip, with its
// time if `frames_per_second` > 0. INVALID_ARGUMENT: a frame that it has not.
absl::StatusOr<Image> FilmFrame(OffscreenRenderer& renderer,
                                const PoseRows& reference, int frame,
                                double frames_per_second = 0);

// One moment of a film, twice the renderer's width: reference left, simulation
// right, seen as in a strip. INVALID_ARGUMENT: a frame that not both have.
absl::StatusOr<Image> SideBySide(OffscreenRenderer& renderer,
                                 const PoseRows& reference,
                                 const PoseRows& simulated, int frame);

}  // namespace sinew::render

#endif  // SINEW_TOOLS_RENDER_FILM_STRIP_H_
