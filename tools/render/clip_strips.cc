// A film strip of every clip of a library, to look at what an import made of
// it: feet on the floor, nothing floats, nothing jumps.
//
//   bazel run //tools/render:clip_strips -- --library DIR --out FOLDER
//       [--character humanoid] [--columns 10]

#include <cstdio>
#include <memory>
#include <string>
#include <vector>

#include "CLI/CLI.hpp"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/str_format.h"
#include "common/files.h"
#include "common/status_macros.h"
#include "sim/character/character.h"
#include "sim/motion/library.h"
#include "tools/render/image.h"
#include "tools/render/offscreen_renderer.h"

namespace sinew::render {
namespace {

constexpr int kWidth = 220;
constexpr int kHeight = 300;

std::vector<double> Pose(const character::Character& character,
                         const motion::FrameView& frame) {
  std::vector<double> qpos(character.model()->nq);
  for (int i = 0; i < 3; ++i) qpos[i] = frame.root_position[i];
  for (int i = 0; i < 4; ++i) qpos[3 + i] = frame.root_rotation[i];
  for (size_t j = 0; j < character.joints().size(); ++j) {
    qpos[character.joints()[j].qpos_address] = frame.joint_position[j];
  }
  return qpos;
}

absl::StatusOr<Image> Strip(const character::Character& character,
                            const motion::Library& library, int clip,
                            int columns, OffscreenRenderer* renderer) {
  const int64_t last = library.clip(clip).num_frames() - 1;
  Image strip(columns * kWidth, kHeight);
  for (int i = 0; i < columns; ++i) {
    const int64_t t = columns > 1 ? last * i / (columns - 1) : 0;
    const std::vector<double> qpos =
        Pose(character, library.frame(clip, t));
    Camera camera;
    camera.target = {qpos[0], qpos[1], 0.85};
    SINEW_ASSIGN_OR_RETURN(
        const Image picture,
        renderer->Render({{.qpos = qpos, .colour = {}}}, camera,
                         absl::StrFormat("%d", t)));
    Paste(picture, i * kWidth, 0, &strip);
  }
  return strip;
}

absl::Status Run(const std::string& name, const std::string& folder,
                 const std::string& out, int columns) {
  SINEW_ASSIGN_OR_RETURN(const auto character,
                         character::Character::Load(name, v1::Physics()));
  SINEW_ASSIGN_OR_RETURN(const auto library, motion::Library::Load(folder));
  if (library->manifest().character_sha256() != character->digest()) {
    return absl::InvalidArgumentError(absl::StrFormat(
        "%s: character_sha256: expected %s (character %s), found %s", folder,
        character->digest(), name, library->manifest().character_sha256()));
  }
  SINEW_ASSIGN_OR_RETURN(
      const auto renderer,
      OffscreenRenderer::Create(PictureModel(*character), kWidth, kHeight));
  SINEW_RETURN_IF_ERROR(MakeDirectories(out));
  for (int clip = 0; clip < library->num_clips(); ++clip) {
    SINEW_ASSIGN_OR_RETURN(
        const Image strip,
        Strip(*character, *library, clip, columns, renderer.get()));
    SINEW_ASSIGN_OR_RETURN(const std::string png, EncodePng(strip));
    SINEW_RETURN_IF_ERROR(WriteFileAtomically(
        JoinPath(out, library->clip(clip).name() + ".png"), png));
  }
  return absl::OkStatus();
}

}  // namespace
}  // namespace sinew::render

int main(int argc, char** argv) {
  std::string character = "humanoid", library, out;
  int columns = 10;
  CLI::App app("Film strips of the clips of a library");
  app.add_option("--library", library, "motion library")->required();
  app.add_option("--out", out, "folder for the pictures")->required();
  app.add_option("--character", character, "name or file");
  app.add_option("--columns", columns, "pictures in a strip")
      ->check(CLI::Range(1, 15));
  CLI11_PARSE(app, argc, argv);
  const absl::Status status =
      sinew::render::Run(character, library, out, columns);
  if (!status.ok()) std::fprintf(stderr, "%s\n", status.ToString().c_str());
  return status.ok() ? 0 : 1;
}
