#ifndef SINEW_SIM_METRICS_LATENT_CONTINUITY_H_
#define SINEW_SIM_METRICS_LATENT_CONTINUITY_H_

#include <cstdint>
#include <vector>

#include "absl/types/span.h"

namespace sinew::metrics {

// How smoothly a latent of width Z moves, over the motions that were added:
//
//   step    mean over consecutive steps of one motion of |z_t - z_t-1|
//   spread  sqrt(mean over all rows of |z - mean z|^2)
//   ratio   step / spread: free of the latent's scale; sqrt(2) for white
//           noise in many dimensions, 0 for a latent that does not move
//           within a motion
struct LatentContinuity {
  int64_t steps = 0;  // pairs of consecutive rows; 0: step means nothing
  double step = 0;
  double spread = 0;
  double ratio = 0;  // 0 where spread is
};

// Thread-safety: one caller. Ownership: none. Blocking: never. Errors: none;
// CHECKs rows of another width.
class LatentMeter {
 public:
  explicit LatentMeter(int width);  // Z >= 1

  // [T, Z] latents of one motion, row-major.
  void AddMotion(absl::Span<const float> rows);
  LatentContinuity figures() const;

 private:
  int64_t steps_ = 0, rows_ = 0;
  double step_sum_ = 0, square_sum_ = 0;
  std::vector<double> sum_;  // [Z]
};

}  // namespace sinew::metrics

#endif  // SINEW_SIM_METRICS_LATENT_CONTINUITY_H_
