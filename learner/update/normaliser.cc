#include "learner/update/normaliser.h"

#include <algorithm>
#include <cmath>

#include "common/check.h"

namespace sinew::learner {
namespace {

constexpr double kVarianceFloor = 1e-8;

}  // namespace

void ComputeMoments(absl::Span<const float> rows,
                    absl::Span<const uint8_t> valid, Moments& out) {
  const size_t width = out.mean.size();
  SINEW_CHECK(rows.size() == valid.size() * width &&
              out.squares.size() == width)
      << rows.size() << " numbers, " << valid.size() << " rows of " << width;
  std::fill(out.mean.begin(), out.mean.end(), 0.0);
  std::fill(out.squares.begin(), out.squares.end(), 0.0);
  out.count = 0;
  for (size_t r = 0; r < valid.size(); ++r) {
    if (valid[r] == 0) continue;
    const float* row = rows.data() + r * width;
    for (size_t c = 0; c < width; ++c) out.mean[c] += row[c];
    out.count += 1;
  }
  if (out.count == 0) return;
  for (double& mean : out.mean) mean /= out.count;
  for (size_t r = 0; r < valid.size(); ++r) {
    if (valid[r] == 0) continue;
    const float* row = rows.data() + r * width;
    for (size_t c = 0; c < width; ++c) {
      const double deviation = row[c] - out.mean[c];
      out.squares[c] += deviation * deviation;
    }
  }
}

void MergeMoments(const Moments& from, Moments& into) {
  const size_t width = into.mean.size();
  SINEW_CHECK(from.mean.size() == width)
      << from.mean.size() << " against " << width;
  if (from.count == 0) return;
  const double count = into.count + from.count;
  const double share = from.count / count;
  for (size_t c = 0; c < width; ++c) {
    const double delta = from.mean[c] - into.mean[c];
    into.mean[c] += delta * share;
    into.squares[c] += from.squares[c] + delta * delta * into.count * share;
  }
  into.count = count;
}

void WriteNormaliser(const Moments& moments, absl::Span<float> mean,
                     absl::Span<float> inverse_std) {
  const size_t width = moments.mean.size();
  SINEW_CHECK(mean.size() == width && inverse_std.size() == width)
      << mean.size() << " and " << inverse_std.size() << " against " << width;
  for (size_t c = 0; c < width; ++c) {
    const double variance =
        moments.count > 0 ? moments.squares[c] / moments.count : 1.0;
    mean[c] = static_cast<float>(moments.mean[c]);
    inverse_std[c] = static_cast<float>(
        moments.count > 0 ? 1.0 / std::sqrt(variance + kVarianceFloor) : 1.0);
  }
}

void InheritMoments(absl::Span<const float> mean,
                    absl::Span<const float> inverse_std, double count,
                    Moments& out) {
  const size_t width = out.mean.size();
  SINEW_CHECK(mean.size() == width && inverse_std.size() == width)
      << mean.size() << " and " << inverse_std.size() << " against " << width;
  out.count = count;
  for (size_t c = 0; c < width; ++c) {
    const double spread = 1.0 / inverse_std[c];
    out.mean[c] = mean[c];
    out.squares[c] = count * std::max(0.0, spread * spread - kVarianceFloor);
  }
}

}  // namespace sinew::learner
