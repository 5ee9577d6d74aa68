#include "sim/motion/clip_digest.h"

#include <cstddef>
#include <cstdint>

#include "absl/strings/str_format.h"
#include "absl/strings/string_view.h"
#include "common/digest.h"
#include "sim/motion/frame_columns.h"

namespace sinew::motion {
namespace {

std::string ClipDigest(const Library& library, int index) {
  const v1::ClipInfo& clip = library.clip(index);
  Sha256 digest;
  digest.Update(absl::StrFormat(
      "clip 1: %.17g Hz, %d frames, loops %d, cycle %.17g %.17g %.17g;",
      library.manifest().frames_per_second(), clip.num_frames(),
      clip.loops() ? 1 : 0, clip.cycle_x(), clip.cycle_y(), clip.cycle_yaw()));
  const FrameView first = library.frame(index, 0);
  const auto columns = FrameColumns();
  for (size_t i = 0; i < columns.size(); ++i) {
    const int64_t width = library.row_widths()[i];
    digest.Update(absl::StrFormat("%s %d;", columns[i].name, width));
    // The rows of a clip lie one after the other.
    digest.Update(absl::string_view(
        reinterpret_cast<const char*>(first.*columns[i].pointer),
        static_cast<size_t>(clip.num_frames() * width) * sizeof(float)));
  }
  return digest.FinishHex();
}

}  // namespace

std::vector<std::string> ClipDigests(const Library& library) {
  std::vector<std::string> digests;
  for (int c = 0; c < library.num_clips(); ++c) {
    digests.push_back(ClipDigest(library, c));
  }
  return digests;
}

}  // namespace sinew::motion
