#include "common/policy/orthogonal.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "absl/types/span.h"
#include "common/check.h"

namespace sinew::policy {
namespace {

// Inner product in one fixed order: eight partial sums that the compiler may
// keep in vector registers without reordering anything.
double Dot(const double* a, const double* b, int64_t size) {
  constexpr int kParts = 8;
  double parts[kParts] = {};
  const int64_t whole = size / kParts * kParts;
  for (int64_t i = 0; i < whole; i += kParts) {
    for (int p = 0; p < kParts; ++p) parts[p] += a[i + p] * b[i + p];
  }
  double sum = 0.0;
  for (const double part : parts) sum += part;
  for (int64_t i = whole; i < size; ++i) sum += a[i] * b[i];
  return sum;
}

// Makes the first `count` rows of length `size` orthonormal in place.
void GramSchmidt(absl::Span<double> rows, int64_t count, int64_t size) {
  for (int64_t i = 0; i < count; ++i) {
    double* row = rows.data() + i * size;
    // The second pass removes what rounding left of the first.
    for (int pass = 0; pass < 2; ++pass) {
      for (int64_t j = 0; j < i; ++j) {
        const double* other = rows.data() + j * size;
        const double share = Dot(row, other, size);
        for (int64_t k = 0; k < size; ++k) row[k] -= share * other[k];
      }
    }
    const double norm = std::sqrt(Dot(row, row, size));
    SINEW_CHECK(norm > 0) << "row " << i << " depends on those before it";
    for (int64_t k = 0; k < size; ++k) row[k] /= norm;
  }
}

}  // namespace

HostTensor OrthogonalWeight(int64_t out, int64_t in, double gain,
                            const RandomKey& key) {
  HostTensor weight = HostTensor::Zeros({out, in});
  const absl::Span<float> values = weight.mutable_float32();
  FillNormal(key, values);
  std::vector<double> rows(values.begin(), values.end());
  // Fewer vectors than dimensions: as rows if out <= in, else the same numbers
  // read as `in` vectors of length `out`.
  const int64_t count = std::min(out, in);
  const int64_t size = std::max(out, in);
  GramSchmidt(absl::MakeSpan(rows), count, size);
  for (int64_t o = 0; o < out; ++o) {
    for (int64_t i = 0; i < in; ++i) {
      const int64_t at = out <= in ? o * in + i : i * out + o;
      values[o * in + i] = static_cast<float>(gain * rows[at]);
    }
  }
  return weight;
}

}  // namespace sinew::policy
