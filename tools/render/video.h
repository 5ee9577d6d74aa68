#ifndef SINEW_TOOLS_RENDER_VIDEO_H_
#define SINEW_TOOLS_RENDER_VIDEO_H_

#include <string>

#include "absl/functional/function_ref.h"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/time/time.h"
#include "common/stop.h"
#include "tools/render/image.h"

namespace sinew::render {

struct VideoOptions {
  double frames_per_second = 30;
  // The encoder's program, looked up in PATH.
  std::string encoder = "ffmpeg";
  // Patience with the encoder.
  absl::Duration timeout = absl::Minutes(10);
};

// OK if the encoder runs; else UNAVAILABLE naming it and its Debian package.
absl::Status CheckEncoder(const VideoOptions& options);

// Pictures of one even size as an mp4 file (H.264), through ffmpeg. The file
// appears whole or not at all; pictures lie in a folder beside it meanwhile.
// Blocking: on `draw` and the encoder. Errors: UNAVAILABLE (CheckEncoder,
// before anything is drawn), CANCELLED, DEADLINE_EXCEEDED, INTERNAL (the
// encoder failed: how it ended, what it said), those of `draw` and the disk.
absl::Status WriteVideo(int frames,
                        absl::FunctionRef<absl::StatusOr<Image>(int)> draw,
                        const std::string& path, const VideoOptions& options,
                        const StopToken& stop);

}  // namespace sinew::render

#endif  // SINEW_TOOLS_RENDER_VIDEO_H_
