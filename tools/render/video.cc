#include "tools/render/video.h"

#include <cerrno>
#include <cstdio>
#include <memory>

#include "absl/cleanup/cleanup.h"
#include "absl/strings/ascii.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "common/files.h"
#include "common/status_macros.h"
#include "common/subprocess.h"

namespace sinew::render {
namespace {

constexpr absl::Duration kVersionTimeout = absl::Seconds(30);
constexpr char kPattern[] = "%06d.png";

absl::Status Encode(const std::string& folder, const std::string& video,
                    const VideoOptions& options, const StopToken& stop) {
  const std::string log = JoinPath(folder, "encoder.log");
  SINEW_ASSIGN_OR_RETURN(
      const auto encoder,
      Subprocess::Start(
          {.argv = {options.encoder, "-y", "-loglevel", "error", "-framerate",
                    absl::StrCat(options.frames_per_second), "-i",
                    JoinPath(folder, kPattern), "-c:v", "libx264", "-pix_fmt",
                    "yuv420p", "-crf", "20", "-movflags", "+faststart", video},
           .output_file = log}));
  SINEW_ASSIGN_OR_RETURN(const ExitStatus exit,
                         encoder->Wait(options.timeout, stop));
  if (exit.ok() && FileExists(video)) return absl::OkStatus();
  const auto said = ReadFile(log);
  return absl::InternalError(absl::StrCat(
      "video: ", options.encoder, ": ", exit.ToString(), ": ",
      said.ok() ? absl::StripAsciiWhitespace(*said) : "it said nothing"));
}

}  // namespace

absl::Status CheckEncoder(const VideoOptions& options) {
  const auto encoder = Subprocess::Start(
      {.argv = {options.encoder, "-version"}, .output_file = "/dev/null"});
  if (encoder.ok()) {
    const auto exit = (*encoder)->Wait(kVersionTimeout);
    if (exit.ok() && exit->ok()) return absl::OkStatus();
  }
  return absl::UnavailableError(
      absl::StrCat("video: expected the program ", options.encoder,
                   " (Debian package ffmpeg), found none that runs"));
}

absl::Status WriteVideo(int frames,
                        absl::FunctionRef<absl::StatusOr<Image>(int)> draw,
                        const std::string& path, const VideoOptions& options,
                        const StopToken& stop) {
  SINEW_RETURN_IF_ERROR(CheckEncoder(options));
  const std::string folder = path + ".frames";
  const auto remove =
      absl::MakeCleanup([&folder] { RemoveRecursively(folder).IgnoreError(); });
  SINEW_RETURN_IF_ERROR(RemoveRecursively(folder));
  SINEW_RETURN_IF_ERROR(MakeDirectories(folder));
  for (int frame = 0; frame < frames; ++frame) {
    if (stop.stop_requested()) {
      return absl::CancelledError("video: stopped before its end");
    }
    SINEW_ASSIGN_OR_RETURN(const Image image, draw(frame));
    SINEW_ASSIGN_OR_RETURN(const std::string png, EncodePng(image));
    SINEW_RETURN_IF_ERROR(WriteFileAtomically(
        JoinPath(folder, absl::StrFormat(kPattern, frame)), png));
  }
  const std::string video = JoinPath(folder, "video.mp4");
  SINEW_RETURN_IF_ERROR(Encode(folder, video, options, stop));
  if (std::rename(video.c_str(), path.c_str()) != 0) {
    return absl::ErrnoToStatus(errno, absl::StrCat("video: ", path));
  }
  return absl::OkStatus();
}

}  // namespace sinew::render
