#include "sim/world/get_up_frames.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace sinew::world {

double UprightRootHeight(const character::Character& character) {
  return kUprightShare * character.proto().standing_root_height();
}

std::vector<StartFrame> GetUpFrames(const v1::Start& recipe,
                                    const character::Character& character,
                                    const motion::Library& library,
                                    double rise_share) {
  const double upright = UprightRootHeight(character);
  const double rise = rise_share * character.proto().standing_root_height();
  std::vector<StartFrame> low;
  for (int32_t clip = 0; clip < library.num_clips(); ++clip) {
    const v1::ClipInfo& info = library.clip(clip);
    const auto height = [&](int64_t frame) {
      return library.frame(clip, frame).root_position[2];
    };
    if (!IsDrawn(recipe, info) || info.loops() || height(0) >= upright ||
        height(info.num_frames() - 1) < upright) {
      continue;
    }
    const double left = std::min(upright, height(0) + rise);
    // The first one belongs to it even if no rise at all is allowed.
    int32_t frame = 0;
    do {
      low.push_back({.clip = clip, .frame = frame});
      ++frame;
    } while (height(frame) < left);
  }
  return low;
}

std::vector<StartFrame> UprightFrames(const v1::Start& recipe,
                                      const character::Character& character,
                                      const motion::Library& library,
                                      double seconds) {
  const int64_t frames_up =
      std::llround(seconds * library.manifest().frames_per_second());
  const double height = UprightRootHeight(character);
  std::vector<StartFrame> upright;
  for (int32_t clip = 0; clip < library.num_clips(); ++clip) {
    const v1::ClipInfo& info = library.clip(clip);
    if (!IsDrawn(recipe, info)) continue;
    const int64_t frames = info.num_frames();
    const auto is_upright = [&](int64_t frame) {
      return library.frame(clip, frame % frames).root_position[2] >= height;
    };
    // Frames of a row that is upright, up to the one at hand.
    int64_t run = 0;
    const int64_t end = info.loops() ? frames + frames_up : frames;
    for (int64_t frame = 0; frame < end; ++frame) {
      run = is_upright(frame) ? run + 1 : 0;
      if (run <= frames_up) continue;
      upright.push_back(
          {.clip = clip, .frame = static_cast<int32_t>(frame - frames_up)});
    }
  }
  return upright;
}

}  // namespace sinew::world
