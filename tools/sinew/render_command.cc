#include "tools/sinew/render_command.h"

#include <cstdio>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "common/files.h"
#include "common/status_macros.h"
#include "tools/evaluation/bundle_subject.h"
#include "tools/evaluation/fallen_figures.h"
#include "tools/evaluation/recording.h"
#include "tools/render/film_strip.h"
#include "tools/render/offscreen_renderer.h"
#include "tools/render/pictures.h"
#include "tools/render/video.h"
#include "tools/sinew/finite_range.h"

namespace sinew::tools {
namespace {

constexpr int kStripColumns = 8;
// Pixels of one body in a video; even, as the encoder wants.
constexpr int kVideoSize = 480;

struct RenderOptions {
  std::string bundle;
  std::string motions;
  std::string clip;           // empty: the first
  std::optional<int> fallen;  // which state, instead of a clip
  bool get_up = false;
  double seconds = 10;
  std::string out;  // folder, .png or .mp4
};

struct Film {
  evaluation::Subject subject;
  std::string name;  // of the clip, or of the start
  evaluation::Recording recording;

  render::PoseRows reference() const {
    return {recording.reference, recording.nq};
  }
  render::PoseRows simulated() const {
    return {recording.simulated, recording.nq};
  }
};

absl::Status WriteStrip(const Film& film, const std::string& path) {
  SINEW_ASSIGN_OR_RETURN(
      const std::string png,
      render::RenderFilmStrip(film.subject.character(), film.reference(),
                              film.simulated(), kStripColumns,
                              film.recording.frames_per_second));
  SINEW_RETURN_IF_ERROR(WriteFileAtomically(path, png));
  absl::PrintF("%s\n", path);
  return absl::OkStatus();
}

absl::Status WriteFilm(const Film& film, const std::string& path,
                       const StopToken& stop) {
  SINEW_ASSIGN_OR_RETURN(const auto renderer,
                         render::OffscreenRenderer::Create(
                             render::PictureModel(film.subject.character()),
                             kVideoSize, kVideoSize));
  render::VideoOptions video;
  video.frames_per_second = film.recording.frames_per_second;
  SINEW_RETURN_IF_ERROR(render::WriteVideo(
      film.recording.frames(),
      [&](int frame) {
        return render::SideBySide(*renderer, film.reference(), film.simulated(),
                                  frame);
      },
      path, video, stop));
  absl::PrintF("%s\n", path);
  return absl::OkStatus();
}

// Both into a folder; without the encoder, the pictures alone.
absl::Status WriteFolder(const Film& film, const std::string& folder,
                         const StopToken& stop) {
  SINEW_RETURN_IF_ERROR(MakeDirectories(folder));
  const std::string stem = JoinPath(folder, film.name);
  SINEW_RETURN_IF_ERROR(WriteStrip(film, stem + ".png"));
  const absl::Status encoder = render::CheckEncoder({});
  if (!encoder.ok()) {
    absl::FPrintF(stderr, "sinew: %s; no video was written\n",
                  std::string(encoder.message()));
    return absl::OkStatus();
  }
  return WriteFilm(film, stem + ".mp4", stop);
}

absl::Status FilmClip(const RenderOptions& options, const StopToken& stop,
                      Film* film) {
  SINEW_ASSIGN_OR_RETURN(
      const int clip,
      evaluation::FindClip(film->subject.library(), options.clip));
  film->name = film->subject.library().clip(clip).name();
  SINEW_ASSIGN_OR_RETURN(
      film->recording,
      evaluation::RecordClip(film->subject, clip, options.seconds, stop));
  if (!film->recording.survived) {
    absl::FPrintF(
        stderr, "sinew: %s: the policy fell after %.2f s\n", film->name,
        (film->recording.frames() - 1) / film->recording.frames_per_second);
  }
  return absl::OkStatus();
}

absl::Status FilmFallen(int state, bool get_up, const StopToken& stop,
                        Film* film) {
  film->name = absl::StrCat(get_up ? "get_up_" : "fallen_", state);
  SINEW_ASSIGN_OR_RETURN(
      film->recording,
      evaluation::RecordFallen(film->subject, state, get_up, stop));
  if (!film->recording.survived) {
    absl::FPrintF(stderr, "sinew: %s: the policy does not stand at the end\n",
                  film->name);
  }
  return absl::OkStatus();
}

absl::Status RunRender(const RenderOptions& options, const StopToken& stop) {
  Film film;
  SINEW_ASSIGN_OR_RETURN(
      evaluation::BundleSubject loaded,
      evaluation::LoadBundleSubject(options.bundle, options.motions,
                                    options.fallen ? *options.fallen + 1 : 0));
  film.subject = std::move(loaded.subject);
  if (options.fallen.has_value()) {
    SINEW_RETURN_IF_ERROR(
        FilmFallen(*options.fallen, options.get_up, stop, &film));
  } else {
    SINEW_RETURN_IF_ERROR(FilmClip(options, stop, &film));
  }
  if (absl::EndsWith(options.out, ".png")) return WriteStrip(film, options.out);
  if (absl::EndsWith(options.out, ".mp4")) {
    return WriteFilm(film, options.out, stop);
  }
  return WriteFolder(film, options.out, stop);
}

}  // namespace

void AddRenderCommand(CLI::App& app, Action& action) {
  auto options = std::make_shared<RenderOptions>();
  auto* command = AddSubcommand<RenderOptions>(app, "render",
                                               "pictures and video of a bundle",
                                               options, action, RunRender);
  command->add_option("bundle", options->bundle, "folder")->required();
  command->add_option("--motions", options->motions, "library")->required();
  command->add_option("--clip", options->clip, "name (default: the first)");
  command->add_option("--seconds", options->seconds, "at most (default 10)")
      ->check(FiniteRange(0, 86400));
  command
      ->add_option("--fallen-state", options->fallen,
                   "from the floor instead: which of the states of "
                   "`sinew eval --fallen`, from 0")
      ->check(CLI::Range(0, evaluation::kMostFallenStarts - 1))
      ->excludes("--clip", "--seconds");
  command
      ->add_flag("--get-up", options->get_up,
                 "with --fallen-state: the reference is the library's nearest "
                 "get-up and what the body goes on with")
      ->needs("--fallen-state");
  command->add_option("--out", options->out, "folder, .png or .mp4 file")
      ->required();
}

}  // namespace sinew::tools
