#ifndef SINEW_SIM_METRICS_DIVERSITY_H_
#define SINEW_SIM_METRICS_DIVERSITY_H_

#include <cstdint>
#include <vector>

#include "absl/status/status.h"
#include "absl/types/span.h"
#include "common/stop.h"

namespace sinew::metrics {

// One motion as diversity sees it. Frame 0 is the start.
struct PosePath {
  // [frames, P, 3] points of the body, metres, relative to the root and in its
  // heading frame (sim/world/body_state.h).
  std::vector<float> points;
  // [frames, 2] the root over the floor, metres, world.
  std::vector<float> root;

  int64_t frames() const { return static_cast<int64_t>(root.size()) / 2; }
};

// How much motions that began in the same state differ. For two of them, i and
// j, the pose distance at frame t is
//
//   p_ij(t) = mean over points of |x_i(t) - x_j(t)|
//
// over the frames 1 .. T that both have. Means over all pairs of one group:
//
//   over_time_m   mean over t of p_ij(t)
//   final_m       p_ij(T)
//   final_root_m  |r_i(T) - r_j(T)|, r the root over the floor
//
// Only pairs of one start count, so that starts that differ do not flatter;
// what does not depend on noise has diversity 0.
struct DiversityFigures {
  int64_t pairs = 0;  // 0: the others mean nothing
  double over_time_m = 0;
  double final_m = 0;
  double final_root_m = 0;
};

// Adds up groups; pairs of groups with one frame alone do not count.
//
// Thread-safety: one caller. Ownership: none. Blocking: computes. Errors:
// AddGroup; CHECKs paths with as many points per frame.
class DiversityMeter {
 public:
  // Motions that began in one state. CANCELLED between two pairs; then the
  // figures mean nothing.
  absl::Status AddGroup(absl::Span<const PosePath> group,
                        const StopToken& stop = {});
  DiversityFigures figures() const;

 private:
  DiversityFigures sums_;
};

}  // namespace sinew::metrics

#endif  // SINEW_SIM_METRICS_DIVERSITY_H_
