#include "common/evaluation/evaluation_starts.h"

#include <cmath>

#include "absl/strings/str_cat.h"

namespace sinew {

absl::StatusOr<std::vector<v1::EvaluationStart>> MakeEvaluationStarts(
    const v1::MotionLibrary& library, int starts, double seconds) {
  if (starts < 1) {
    return absl::InvalidArgumentError(
        absl::StrCat("evaluation starts: expected >= 1, found ", starts));
  }
  const double steps = std::round(seconds * library.frames_per_second());
  if (!(steps >= 1 && steps < 1e9)) {
    return absl::InvalidArgumentError(
        absl::StrCat("evaluation seconds: expected at least one frame at ",
                     library.frames_per_second(), " Hz, found ", seconds));
  }
  std::vector<v1::EvaluationStart> out;
  for (int c = 0; c < library.clips_size(); ++c) {
    const v1::ClipInfo& clip = library.clips(c);
    const int64_t last = clip.num_frames() - 1;
    const int64_t span = clip.loops() ? clip.num_frames() : (last + 1) / 2;
    for (int k = 0; k < starts; ++k) {
      const int64_t frame = k * span / starts;
      v1::EvaluationStart& start = out.emplace_back();
      start.set_clip(c);
      start.set_start_frame(static_cast<int32_t>(frame));
      start.set_steps(static_cast<int32_t>(
          clip.loops() ? static_cast<int64_t>(steps) : last - frame));
    }
  }
  return out;
}

}  // namespace sinew
