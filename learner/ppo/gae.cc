#include "learner/ppo/gae.h"

#include <algorithm>

#include "common/check.h"

namespace sinew::learner {

void ComputeGae(const GaeGrid& grid, double discount, double lambda,
                absl::Span<float> advantages, absl::Span<float> returns) {
  const size_t size = grid.steps * grid.environments;
  SINEW_CHECK(grid.rewards.size() == size && grid.values.size() == size &&
              grid.next_values.size() == size &&
              grid.terminated.size() == size && grid.truncated.size() == size &&
              advantages.size() == size && returns.size() == size)
      << "grid of " << grid.steps << " x " << grid.environments;
  const float gamma = static_cast<float>(discount);
  const float decay = static_cast<float>(discount * lambda);
  const int64_t width = grid.environments;
  for (int64_t t = grid.steps - 1; t >= 0; --t) {
    const int64_t row = t * width;
    const bool last = t == grid.steps - 1;
    for (int64_t i = row; i < row + width; ++i) {
      const float next = grid.terminated[i] ? 0.0f : grid.next_values[i];
      const bool ends = last || grid.terminated[i] || grid.truncated[i];
      const float trace = ends ? 0.0f : advantages[i + width];
      const float delta = grid.rewards[i] + gamma * next - grid.values[i];
      advantages[i] = delta + decay * trace;
      returns[i] = advantages[i] + grid.values[i];
    }
  }
}

void FillNextValues(absl::Span<const float> values,
                    absl::Span<const float> boundary_values,
                    absl::Span<const int32_t> truncation_index,
                    absl::Span<const float> truncation_values,
                    absl::Span<float> next_values) {
  const size_t width = boundary_values.size();
  SINEW_CHECK(next_values.size() == values.size() && values.size() >= width &&
              truncation_index.size() == truncation_values.size())
      << "values " << values.size() << ", boundary " << width;
  auto end =
      std::copy(values.begin() + width, values.end(), next_values.begin());
  std::copy(boundary_values.begin(), boundary_values.end(), end);
  for (size_t k = 0; k < truncation_index.size(); ++k) {
    next_values[truncation_index[k]] = truncation_values[k];
  }
}

}  // namespace sinew::learner
