#include "sim/world/get_up_frames.h"

#include <cmath>
#include <cstdint>

namespace sinew::world {

double UprightRootHeight(const character::Character& character) {
  return kUprightShare * character.proto().standing_root_height();
}

std::vector<StartFrame> GetUpFrames(const v1::Start& recipe,
                                    const character::Character& character,
                                    const motion::Library& library) {
  const double height = UprightRootHeight(character);
  const auto is_low = [&](int32_t clip, int32_t frame) {
    return library.frame(clip, frame).root_position[2] < height;
  };
  std::vector<StartFrame> low;
  for (int32_t clip = 0; clip < library.num_clips(); ++clip) {
    const v1::ClipInfo& info = library.clip(clip);
    const auto frames = static_cast<int32_t>(info.num_frames());
    if (!IsDrawn(recipe, info) || info.loops() || !is_low(clip, 0) ||
        is_low(clip, frames - 1)) {
      continue;
    }
    for (int32_t frame = 0; frame < frames; ++frame) {
      if (is_low(clip, frame)) low.push_back({.clip = clip, .frame = frame});
    }
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
