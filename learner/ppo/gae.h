#ifndef SINEW_LEARNER_PPO_GAE_H_
#define SINEW_LEARNER_PPO_GAE_H_

#include <cstdint>

#include "absl/types/span.h"

namespace sinew::learner {

// Generalised advantage estimation (Schulman et al., "High-dimensional
// continuous control using generalized advantage estimation", 2016, equations
// 11 to 16), over a grid of T steps of E environments. With discount gamma and
// decay lambda:
//
//   delta_t = r_t + gamma V(s_{t+1}) - V(s_t)     V(s_{t+1}) = 0 if terminated
//   A_t     = delta_t + gamma lambda c_t A_{t+1}  c_t = 0 where an episode ends
//   R_t     = A_t + V(s_t)                        the lambda-return
//
// Three ways in which a trace ends, kept apart:
//   terminated  the episode failed: no value follows
//   truncated   the episode was cut: the value of its successor follows
//   t = T - 1   the grid ends: likewise
//
// All arrays are row-major [T, E]; values and rewards share one unit (the
// discounted sum of rewards, not scaled). Arithmetic is float32.
//
// Pure functions: thread-safe, no allocation, never blocking. NaN in a trace
// gives NaN in that trace's earlier steps and nowhere else; sizes are CHECKed.
struct GaeGrid {
  int64_t steps = 0;         // T
  int64_t environments = 0;  // E
  absl::Span<const float> rewards;
  absl::Span<const float> values;       // V(s_t)
  absl::Span<const float> next_values;  // V(s_{t+1}), see FillNextValues
  absl::Span<const uint8_t> terminated;
  absl::Span<const uint8_t> truncated;
};

// Writes A and R, both [T, E]; they must not overlap the inputs.
void ComputeGae(const GaeGrid& grid, double discount, double lambda,
                absl::Span<float> advantages, absl::Span<float> returns);

// Values of the successors, [T, E]: those of the next row, of
// `boundary_values` [E] behind the last row, and of `truncation_values` [K] at
// the flat indices `truncation_index` [K] (t * E + e, within the grid). What
// stands at terminated steps has no meaning; ComputeGae does not read it.
void FillNextValues(absl::Span<const float> values,
                    absl::Span<const float> boundary_values,
                    absl::Span<const int32_t> truncation_index,
                    absl::Span<const float> truncation_values,
                    absl::Span<float> next_values);

}  // namespace sinew::learner

#endif  // SINEW_LEARNER_PPO_GAE_H_
