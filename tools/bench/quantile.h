#ifndef SINEW_TOOLS_BENCH_QUANTILE_H_
#define SINEW_TOOLS_BENCH_QUANTILE_H_

#include <algorithm>
#include <cstddef>
#include <utility>
#include <vector>

namespace sinew::bench {

// The value below which this share of the others lies, [0, 1], one of
// `values`: the nearest, the upper of two. They are not empty and none is NaN.
//
// Pure; does not block; no errors.
inline double Quantile(std::vector<double> values, double share) {
  std::sort(values.begin(), values.end());
  const auto last = static_cast<double>(values.size() - 1);
  return values[static_cast<size_t>(share * last + 0.5)];
}

inline double Median(std::vector<double> values) {
  return Quantile(std::move(values), 0.5);
}

}  // namespace sinew::bench

#endif  // SINEW_TOOLS_BENCH_QUANTILE_H_
