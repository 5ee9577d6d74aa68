#include "sim/metrics/latent_continuity.h"

#include <algorithm>
#include <cmath>

#include "common/check.h"

namespace sinew::metrics {

LatentMeter::LatentMeter(int width) : sum_(static_cast<size_t>(width)) {
  SINEW_CHECK(width >= 1);
}

void LatentMeter::AddMotion(absl::Span<const float> rows) {
  const size_t width = sum_.size();
  SINEW_CHECK(rows.size() % width == 0) << rows.size() << " numbers";
  for (size_t at = 0; at < rows.size(); at += width) {
    double step = 0;
    for (size_t i = 0; i < width; ++i) {
      const double value = rows[at + i];
      sum_[i] += value;
      square_sum_ += value * value;
      if (at == 0) continue;
      const double change = value - rows[at - width + i];
      step += change * change;
    }
    ++rows_;
    if (at == 0) continue;
    ++steps_;
    step_sum_ += std::sqrt(step);
  }
}

LatentContinuity LatentMeter::figures() const {
  LatentContinuity result;
  result.steps = steps_;
  if (steps_ > 0) result.step = step_sum_ / static_cast<double>(steps_);
  if (rows_ == 0) return result;
  const auto rows = static_cast<double>(rows_);
  double mean_square = 0;
  for (const double sum : sum_) mean_square += (sum / rows) * (sum / rows);
  // Rounding may leave less than nothing.
  result.spread = std::sqrt(std::max(0.0, square_sum_ / rows - mean_square));
  if (result.spread > 0) result.ratio = result.step / result.spread;
  return result;
}

}  // namespace sinew::metrics
