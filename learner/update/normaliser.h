#ifndef SINEW_LEARNER_UPDATE_NORMALISER_H_
#define SINEW_LEARNER_UPDATE_NORMALISER_H_

#include <cstdint>
#include <vector>

#include "absl/types/span.h"

namespace sinew::learner {

// Mean and sum of squared deviations of rows, per column, in float64.
struct Moments {
  explicit Moments(int64_t width = 0) : mean(width), squares(width) {}

  double count = 0;             // rows
  std::vector<double> mean;     // [width]
  std::vector<double> squares;  // [width], sum of (x - mean)^2
};

// Moments of the rows [rows, width] whose flag in `valid` [rows] is not 0: two
// passes, mean first. Overwrites `out`; no allocation if it has the width.
// Non-finite rows make their columns non-finite: check before.
void ComputeMoments(absl::Span<const float> rows,
                    absl::Span<const uint8_t> valid, Moments& out);

// Moments of both sets together, into `into` (Chan, Golub and LeVeque,
// "Updating formulae and a pairwise algorithm for computing sample variances",
// 1979):
//   delta = mean_b - mean_a,  n = n_a + n_b
//   mean = mean_a + delta n_b / n
//   squares = squares_a + squares_b + delta^2 n_a n_b / n
// Not commutative in the last bit: merge in a fixed order.
void MergeMoments(const Moments& from, Moments& into);

// What a NORMALISE node reads: mean, and 1 / sqrt(variance + 1e-8), float32
// [width]. A column whose spread is below 1e-4 of its unit is thus never blown
// up by more than 1e4. Without rows: 0 and 1.
void WriteNormaliser(const Moments& moments, absl::Span<float> mean,
                     absl::Span<float> inverse_std);

// Rows that a normaliser taken over from another run counts for, unless the
// recipe says another number.
inline constexpr double kInheritedRows = 131072;

// The inverse: moments of `count` rows that WriteNormaliser would turn into
// these numbers.
void InheritMoments(absl::Span<const float> mean,
                    absl::Span<const float> inverse_std, double count,
                    Moments& out);

// All pure functions: thread-safe, never blocking; widths are CHECKed.

}  // namespace sinew::learner

#endif  // SINEW_LEARNER_UPDATE_NORMALISER_H_
