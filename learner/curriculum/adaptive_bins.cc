#include "learner/curriculum/adaptive_bins.h"

#include <algorithm>
#include <cstddef>

namespace sinew::learner {

std::vector<ClipLimits> LimitClips(absl::Span<const double> frames,
                                   double bin_floor, double clip_floor,
                                   double clip_cap) {
  double clips = 0, all_frames = 0;
  for (const double n : frames) {
    clips += n > 0 ? 1 : 0;
    all_frames += n;
  }
  std::vector<ClipLimits> limits(frames.size(), ClipLimits{0, 0});
  double floors = 0;
  for (size_t c = 0; c < frames.size(); ++c) {
    if (frames[c] == 0) continue;
    limits[c].floor_share =
        std::max(bin_floor * frames[c] / all_frames, clip_floor / clips);
    floors += limits[c].floor_share;
  }
  for (size_t c = 0; c < frames.size(); ++c) {
    if (frames[c] == 0) continue;
    if (floors > 1) limits[c].floor_share /= floors;
    limits[c].cap =
        std::max({clip_cap, std::min(1.0, 2 / clips), limits[c].floor_share});
  }
  return limits;
}

std::vector<double> ShareAboveFloors(absl::Span<const ClipLimits> limits,
                                     absl::Span<const double> weights) {
  std::vector<double> extras(limits.size(), 0.0);
  std::vector<bool> full(limits.size(), false);
  for (bool changed = true; changed;) {
    changed = false;
    // What is left for clips that are not full, and their weights.
    double rest = 1, weight = 0;
    for (size_t c = 0; c < limits.size(); ++c) {
      rest -= limits[c].floor_share + (full[c] ? extras[c] : 0);
      weight += full[c] ? 0 : weights[c];
    }
    rest = std::max(0.0, rest);  // rounding
    for (size_t c = 0; c < limits.size(); ++c) {
      if (full[c] || weights[c] == 0) continue;
      const double room = limits[c].cap - limits[c].floor_share;
      extras[c] = rest * weights[c] / weight;
      if (extras[c] <= room) continue;
      extras[c] = room;
      full[c] = true;
      changed = true;
    }
  }
  return extras;
}

}  // namespace sinew::learner
