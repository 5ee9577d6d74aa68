#include "common/policy/linear_kernel.h"

#include "common/policy/vector_math.h"

namespace sinew::policy::internal {
namespace {

// kRowBlock rows against one panel: eight accumulators, enough to hide the
// latency of the multiply-adds, and all in registers.
inline void Block(const LinearShape& shape, const float* x, const float* panel,
                  const float* bias, float* y) {
  Float8 left[kRowBlock];
  Float8 right[kRowBlock];
#pragma clang loop unroll(full)
  for (int r = 0; r < kRowBlock; ++r) {
    left[r] = Load(bias);
    right[r] = Load(bias + kLanes);
  }
  for (int64_t k = 0; k < shape.k; ++k) {
    const Float8 w_left = Load(panel + k * kPanel);
    const Float8 w_right = Load(panel + k * kPanel + kLanes);
#pragma clang loop unroll(full)
    for (int r = 0; r < kRowBlock; ++r) {
      const Float8 x_rk = Splat(x[r * shape.x_stride + k]);
      left[r] = Fma(x_rk, w_left, left[r]);
      right[r] = Fma(x_rk, w_right, right[r]);
    }
  }
#pragma clang loop unroll(full)
  for (int r = 0; r < kRowBlock; ++r) {
    Store(y + r * shape.y_stride, left[r]);
    Store(y + r * shape.y_stride + kLanes, right[r]);
  }
}

}  // namespace

AlignedBuffer PackPanels(absl::Span<const float> weight, int64_t n, int64_t k) {
  AlignedBuffer packed(RoundUp(n, kPanel) * k);
  for (int64_t j = 0; j < n; ++j) {
    float* panel = packed.data() + j / kPanel * kPanel * k + j % kPanel;
    for (int64_t i = 0; i < k; ++i) panel[i * kPanel] = weight[j * k + i];
  }
  return packed;
}

void Linear(const LinearShape& shape, const float* x, const float* panels,
            const float* bias, float* y) {
  for (int64_t j = 0; j < shape.n; j += kPanel) {
    // A panel stays in the first-level cache for all rows.
    const float* panel = panels + j * shape.k;
    for (int64_t r = 0; r < shape.rows; r += kRowBlock) {
      Block(shape, x + r * shape.x_stride, panel, bias + j,
            y + r * shape.y_stride + j);
    }
  }
}

}  // namespace sinew::policy::internal
