#ifndef SINEW_COMMON_POLICY_LINEAR_KERNEL_H_
#define SINEW_COMMON_POLICY_LINEAR_KERNEL_H_

#include <cstdint>

#include "absl/types/span.h"
#include "common/policy/aligned_buffer.h"

namespace sinew::policy::internal {

// Rows that are computed together, and outputs of one panel.
inline constexpr int kRowBlock = 4;
inline constexpr int kPanel = 16;

inline int64_t RoundUp(int64_t n, int64_t to) { return (n + to - 1) / to * to; }

// weight[n, k] (row-major) as [n / 16][k][16] panels; missing outputs are 0.
AlignedBuffer PackPanels(absl::Span<const float> weight, int64_t n, int64_t k);

// y[r, j] = bias[j] + sum over k of x[r, k] * weight[j, k]: one fused
// multiply-add per k, ascending, whatever r and the number of rows.
//
// x [rows, x_stride] and y [rows, y_stride] hold a multiple of kRowBlock rows;
// y_stride >= RoundUp(n, kPanel), and bias is padded likewise. Columns of y
// from n on become 0.
struct LinearShape {
  int64_t rows;  // a multiple of kRowBlock
  int64_t k;
  int64_t n;
  int64_t x_stride;
  int64_t y_stride;
};
void Linear(const LinearShape& shape, const float* x, const float* panels,
            const float* bias, float* y);

}  // namespace sinew::policy::internal

#endif  // SINEW_COMMON_POLICY_LINEAR_KERNEL_H_
