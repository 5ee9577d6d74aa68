#include "tools/report/film.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "common/status_macros.h"
#include "tools/evaluation/recording.h"
#include "tools/render/film_strip.h"
#include "tools/render/image.h"
#include "tools/render/offscreen_renderer.h"

namespace sinew::report {
namespace {

constexpr int kQuality = 82;
// Moments beside each other in the sheet: keeps it within what browsers
// decode on small devices.
constexpr int kSheetColumns = 6;

// Frames of the recording that the sheet shows.
std::vector<int> Moments(const evaluation::Recording& recording,
                         double per_second) {
  const double step = std::max(1.0, recording.frames_per_second / per_second);
  std::vector<int> moments;
  for (double at = 0; std::lround(at) < recording.frames(); at += step) {
    moments.push_back(static_cast<int>(std::lround(at)));
  }
  return moments;
}

absl::StatusOr<render::Image> Sheet(render::OffscreenRenderer& renderer,
                                    const render::PoseRows& reference,
                                    const render::PoseRows& simulated,
                                    const std::vector<int>& moments,
                                    const StopToken& stop) {
  const int width = 2 * renderer.width(), height = renderer.height();
  const int count = static_cast<int>(moments.size());
  const int columns = std::min(count, kSheetColumns);
  render::Image sheet(columns * width,
                      (count + columns - 1) / columns * height);
  for (int i = 0; i < count; ++i) {
    if (stop.stop_requested()) {
      return absl::CancelledError("report: stopped before its end");
    }
    SINEW_ASSIGN_OR_RETURN(
        const render::Image moment,
        render::SideBySide(renderer, reference, simulated, moments[i]));
    render::Paste(moment, i % columns * width, i / columns * height, &sheet);
  }
  return sheet;
}

}  // namespace

absl::StatusOr<Json> MakeFilm(const evaluation::Subject& subject, int clip,
                              const FilmOptions& options,
                              const StopToken& stop) {
  SINEW_ASSIGN_OR_RETURN(
      const evaluation::Recording recording,
      evaluation::RecordClip(subject, clip, options.seconds, stop));
  const render::PoseRows reference{recording.reference, recording.nq};
  const render::PoseRows simulated{recording.simulated, recording.nq};
  SINEW_ASSIGN_OR_RETURN(const auto renderer,
                         render::OffscreenRenderer::Create(
                             render::PictureModel(subject.character()),
                             options.width, options.height));
  const std::vector<int> moments =
      Moments(recording, options.pictures_per_second);
  SINEW_ASSIGN_OR_RETURN(const render::Image sheet,
                         Sheet(*renderer, reference, simulated, moments, stop));
  SINEW_ASSIGN_OR_RETURN(
      const render::Image strip,
      render::FilmStrip(*renderer, reference, simulated, options.strip_columns,
                        recording.frames_per_second));
  Json film = {
      {"clip", subject.library().clip(clip).name()},
      {"survived", recording.survived},
      {"seconds", (recording.frames() - 1) / recording.frames_per_second},
      {"fps",
       std::min(options.pictures_per_second, recording.frames_per_second)},
      {"frames", moments.size()},
      {"columns", sheet.width / (2 * options.width)},
      {"width", 2 * options.width},
      {"height", options.height}};
  SINEW_ASSIGN_OR_RETURN(film["sheet"], render::JpegDataUri(sheet, kQuality));
  SINEW_ASSIGN_OR_RETURN(film["strip"], render::JpegDataUri(strip, kQuality));
  return film;
}

}  // namespace sinew::report
