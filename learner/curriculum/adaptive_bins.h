#ifndef SINEW_LEARNER_CURRICULUM_ADAPTIVE_BINS_H_
#define SINEW_LEARNER_CURRICULUM_ADAPTIVE_BINS_H_

#include <vector>

#include "absl/types/span.h"

namespace sinew::learner {

// The law of RULE_ADAPTIVE_BINS. Over C clips (those with bins), bins b of
// frames n_b, and recent failure rates r_b (bin_sums.h):
//
//   floor of clip c   F_c = max(bin_floor * n_c / n, clip_floor / C);
//                     all are divided by their sum where that is above 1
//   cap of clip c     K_c = max(clip_cap, min(1, 2 / C), F_c)
//   weight            w_b = n_b r_b, w_c its sum over the clip
//   weight of clip c  W_c = w_c (CLIP_WEIGHT_BINS), or 1 where it failed its
//                     latest evaluation or had none, and 1e-6 w_c / n_c where
//                     it was won (CLIP_WEIGHT_EVALUATIONS)
//   extra of clip c   E_c = min(K_c - F_c, lambda W_c), lambda such that
//                     all E_c and all F_c sum to 1
//   probability       p_b = F_c n_b / n_c + E_c w_b / w_c
//
// So every bin keeps bin_floor times what the uniform rule gives it, every clip
// clip_floor / C, and no clip has more than K_c: what is above goes to the
// others in proportion to their weights. A solution always exists, since the
// floors sum to at most 1 and the caps to at least 1: a cap that few clips
// could not fill is lifted to twice the even share, or they could not differ at
// all. A bin's probability never falls when its failures rise.

struct ClipLimits {
  double floor_share;  // F_c
  double cap;          // K_c
};

// F_c and K_c. `frames` [C]: n_c, 0 for clips that have no bins: these get 0
// and 0, and do not count. Pure.
std::vector<ClipLimits> LimitClips(absl::Span<const double> frames,
                                   double bin_floor, double clip_floor,
                                   double clip_cap);

// E_c. `weights` [C]: W_c, > 0 unless the clip has no bins. Pure.
std::vector<double> ShareAboveFloors(absl::Span<const ClipLimits> limits,
                                     absl::Span<const double> weights);

}  // namespace sinew::learner

#endif  // SINEW_LEARNER_CURRICULUM_ADAPTIVE_BINS_H_
