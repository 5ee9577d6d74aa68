#ifndef SINEW_TOOLS_BENCH_THREAD_SECONDS_H_
#define SINEW_TOOLS_BENCH_THREAD_SECONDS_H_

#include <time.h>

#include <algorithm>
#include <vector>

namespace sinew::bench {

// CPU seconds of the calling thread so far: what other programs on the machine
// take from it does not count.
inline double ThreadSeconds() {
  timespec now;
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) +
         1e-9 * static_cast<double>(now.tv_nsec);
}

// Middle value; NaN-free, not empty.
inline double Median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<long>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace sinew::bench

#endif  // SINEW_TOOLS_BENCH_THREAD_SECONDS_H_
