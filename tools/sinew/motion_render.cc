#include "tools/sinew/motion_render.h"

#include <cstdio>
#include <memory>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_replace.h"
#include "common/config/recipe.h"
#include "common/files.h"
#include "common/status_macros.h"
#include "sim/character/character.h"
#include "sim/motion/library.h"
#include "tools/evaluation/recording.h"
#include "tools/evaluation/subject.h"
#include "tools/render/film_strip.h"
#include "tools/render/image.h"
#include "tools/render/offscreen_renderer.h"
#include "tools/render/video.h"
#include "tools/sinew/finite_range.h"

namespace sinew::tools {
namespace {

constexpr int kColumns = 8;
constexpr int kWidth = 240, kHeight = 360;
// Pixels of a video; even, as the encoder wants.
constexpr int kVideoSize = 480;

struct RenderOptions {
  std::string library;
  std::string clip;       // empty: all
  std::string character;  // empty: the library's
  std::string out;        // folder; empty: pictures/ in the library
  bool video = false;
  double seconds = 20;  // of a video at most
};

// The name as that of a file: slashes are none.
std::string FileName(const motion::Library& library, int clip) {
  return absl::StrReplaceAll(library.clip(clip).name(), {{"/", "_"}});
}

absl::Status WriteStrip(render::OffscreenRenderer& renderer,
                        const character::Character& character,
                        const motion::Library& library, int clip,
                        const std::string& folder) {
  const auto frames = static_cast<int>(library.clip(clip).num_frames());
  const auto nq = static_cast<int>(character.model()->nq);
  const std::vector<double> poses =
      evaluation::ReferencePoses(character, library, clip, /*first=*/0, frames);
  SINEW_ASSIGN_OR_RETURN(
      const render::Image strip,
      render::ReferenceStrip(renderer, {poses, nq}, kColumns,
                             library.manifest().frames_per_second()));
  SINEW_ASSIGN_OR_RETURN(const std::string png, render::EncodePng(strip));
  const std::string path = JoinPath(folder, FileName(library, clip) + ".png");
  SINEW_RETURN_IF_ERROR(WriteFileAtomically(path, png));
  absl::PrintF("%s\n", path);
  return absl::OkStatus();
}

absl::Status WriteFilm(render::OffscreenRenderer& renderer,
                       const character::Character& character,
                       const motion::Library& library, int clip, double seconds,
                       const std::string& folder, const StopToken& stop) {
  const double rate = library.manifest().frames_per_second();
  const int frames = evaluation::FramesToShow(library, clip, seconds);
  const auto nq = static_cast<int>(character.model()->nq);
  const std::vector<double> poses =
      evaluation::ReferencePoses(character, library, clip, /*first=*/0, frames);
  const render::PoseRows rows{poses, nq};
  render::VideoOptions video;
  video.frames_per_second = rate;
  const std::string path = JoinPath(folder, FileName(library, clip) + ".mp4");
  SINEW_RETURN_IF_ERROR(render::WriteVideo(
      frames,
      [&](int frame) { return render::FilmFrame(renderer, rows, frame, rate); },
      path, video, stop));
  absl::PrintF("%s\n", path);
  return absl::OkStatus();
}

absl::Status CheckCharacter(const character::Character& character,
                            const motion::Library& library) {
  if (character.digest() == library.manifest().character_sha256()) {
    return absl::OkStatus();
  }
  return absl::InvalidArgumentError(
      absl::StrCat("motion library field character_sha256: expected ",
                   character.digest(), " (character ", character.name(),
                   "), found ", library.manifest().character_sha256(),
                   " (character ", library.manifest().character(), ")"));
}

absl::Status RunRender(const RenderOptions& options, const StopToken& stop) {
  SINEW_ASSIGN_OR_RETURN(const auto library,
                         motion::Library::Load(options.library));
  SINEW_ASSIGN_OR_RETURN(
      const auto character,
      character::Character::Load(options.character.empty()
                                     ? library->manifest().character()
                                     : options.character,
                                 WithDefaults(v1::Recipe()).physics()));
  SINEW_RETURN_IF_ERROR(CheckCharacter(*character, *library));
  SINEW_ASSIGN_OR_RETURN(const int only,
                         evaluation::FindClip(*library, options.clip));
  if (options.video) SINEW_RETURN_IF_ERROR(render::CheckEncoder({}));
  SINEW_ASSIGN_OR_RETURN(
      const auto renderer,
      render::OffscreenRenderer::Create(render::PictureModel(*character),
                                        options.video ? kVideoSize : kWidth,
                                        options.video ? kVideoSize : kHeight));
  const std::string folder =
      options.out.empty() ? JoinPath(options.library, "pictures") : options.out;
  SINEW_RETURN_IF_ERROR(MakeDirectories(folder));
  for (int clip = 0; clip < library->num_clips(); ++clip) {
    if (!options.clip.empty() && clip != only) continue;
    if (stop.stop_requested()) return absl::CancelledError("stopped");
    SINEW_RETURN_IF_ERROR(
        options.video
            ? WriteFilm(*renderer, *character, *library, clip, options.seconds,
                        folder, stop)
            : WriteStrip(*renderer, *character, *library, clip, folder));
  }
  return absl::OkStatus();
}

}  // namespace

void AddMotionRender(CLI::App& motion, Action& action) {
  auto options = std::make_shared<RenderOptions>();
  auto* command = AddSubcommand<RenderOptions>(
      motion, "render", "film strips or videos of a library's clips", options,
      action, RunRender);
  command->add_option("library", options->library, "folder")->required();
  command->add_option("--clip", options->clip, "name (default: all)");
  command->add_option("--character", options->character,
                      "name or file (default: the library's)");
  command->add_option("--out", options->out,
                      "folder (default: pictures/ in the library)");
  CLI::Option* video =
      command->add_flag("--video", options->video,
                        "videos instead (needs ffmpeg; seconds per clip)");
  command
      ->add_option("--seconds", options->seconds,
                   "of a video at most (default 20)")
      ->check(FiniteRange(0, 86400))
      ->needs(video);
}

}  // namespace sinew::tools
