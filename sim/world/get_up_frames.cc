#include "sim/world/get_up_frames.h"

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

}  // namespace sinew::world
