#include "tools/render/film_strip.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "common/status_macros.h"
#include "tools/render/following_camera.h"

namespace sinew::render {
namespace {

absl::Status Check(const OffscreenRenderer& renderer, const PoseRows& rows,
                   const char* which) {
  if (rows.nq != renderer.model().nq || rows.frames() < 1) {
    return absl::InvalidArgumentError(absl::StrCat(
        "film strip: ", which, ": expected frames of ", renderer.model().nq,
        " numbers, found ", rows.frames(), " of ", rows.nq));
  }
  return absl::OkStatus();
}

// The time of a frame; empty where nobody knows it.
std::string Caption(int frame, double frames_per_second) {
  return frames_per_second > 0
             ? absl::StrFormat("%.2f s", frame / frames_per_second)
             : "";
}

// `rows` were checked and `columns` is positive.
absl::StatusOr<Image> Strip(OffscreenRenderer& renderer,
                            absl::Span<const PoseRows> rows, int columns,
                            double frames_per_second) {
  int last = rows.front().frames() - 1;
  for (const PoseRows& row : rows) last = std::min(last, row.frames() - 1);
  const FollowingCamera following(rows.front().row(0));
  Image strip(columns * renderer.width(),
              static_cast<int>(rows.size()) * renderer.height());
  for (int column = 0; column < columns; ++column) {
    const int frame =
        columns == 1 ? 0
                     : static_cast<int>(std::lround(static_cast<double>(last) *
                                                    column / (columns - 1)));
    const Camera camera = following.At(rows.front().row(frame));
    const std::string caption = Caption(frame, frames_per_second);
    for (size_t r = 0; r < rows.size(); ++r) {
      SINEW_ASSIGN_OR_RETURN(
          const Image picture,
          renderer.Render({{{rows[r].row(frame), std::nullopt}}}, camera,
                          r == 0 ? caption : ""));
      Paste(picture, column * renderer.width(),
            static_cast<int>(r) * renderer.height(), &strip);
    }
  }
  return strip;
}

absl::Status CheckColumns(int columns) {
  if (columns >= 1) return absl::OkStatus();
  return absl::InvalidArgumentError(absl::StrCat(
      "film strip: columns: expected at least 1, found ", columns));
}

}  // namespace

absl::StatusOr<Image> FilmStrip(OffscreenRenderer& renderer,
                                const PoseRows& reference,
                                const PoseRows& simulated, int columns,
                                double frames_per_second) {
  SINEW_RETURN_IF_ERROR(Check(renderer, reference, "reference"));
  SINEW_RETURN_IF_ERROR(Check(renderer, simulated, "simulated"));
  SINEW_RETURN_IF_ERROR(CheckColumns(columns));
  const std::array<PoseRows, 2> rows = {reference, simulated};
  return Strip(renderer, rows, columns, frames_per_second);
}

absl::StatusOr<Image> ReferenceStrip(OffscreenRenderer& renderer,
                                     const PoseRows& reference, int columns,
                                     double frames_per_second) {
  SINEW_RETURN_IF_ERROR(Check(renderer, reference, "reference"));
  SINEW_RETURN_IF_ERROR(CheckColumns(columns));
  return Strip(renderer, {reference}, columns, frames_per_second);
}

absl::StatusOr<Image> FilmFrame(OffscreenRenderer& renderer,
                                const PoseRows& reference, int frame,
                                double frames_per_second) {
  SINEW_RETURN_IF_ERROR(Check(renderer, reference, "reference"));
  if (frame < 0 || frame >= reference.frames()) {
    return absl::InvalidArgumentError(
        absl::StrCat("film: expected a frame of 0 to ", reference.frames() - 1,
                     ", found ", frame));
  }
  return renderer.Render(
      {{{reference.row(frame), std::nullopt}}},
      FollowingCamera(reference.row(0)).At(reference.row(frame)),
      Caption(frame, frames_per_second));
}

absl::StatusOr<Image> SideBySide(OffscreenRenderer& renderer,
                                 const PoseRows& reference,
                                 const PoseRows& simulated, int frame) {
  SINEW_RETURN_IF_ERROR(Check(renderer, reference, "reference"));
  SINEW_RETURN_IF_ERROR(Check(renderer, simulated, "simulated"));
  const int frames = std::min(reference.frames(), simulated.frames());
  if (frame < 0 || frame >= frames) {
    return absl::InvalidArgumentError(
        absl::StrCat("side by side: expected a frame of 0 to ", frames - 1,
                     ", found ", frame));
  }
  const Camera camera =
      FollowingCamera(reference.row(0)).At(reference.row(frame));
  SINEW_ASSIGN_OR_RETURN(
      const Image left,
      renderer.Render({{{reference.row(frame), std::nullopt}}}, camera));
  SINEW_ASSIGN_OR_RETURN(
      const Image right,
      renderer.Render({{{simulated.row(frame), std::nullopt}}}, camera));
  Image both(2 * renderer.width(), renderer.height());
  Paste(left, 0, 0, &both);
  Paste(right, renderer.width(), 0, &both);
  return both;
}

}  // namespace sinew::render
