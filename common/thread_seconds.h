#ifndef SINEW_COMMON_THREAD_SECONDS_H_
#define SINEW_COMMON_THREAD_SECONDS_H_

#include <time.h>

namespace sinew {

// CPU seconds of the calling thread so far: what other programs on the machine
// take from it does not count. Thread-safety: yes.
inline double ThreadSeconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) +
         1e-9 * static_cast<double>(now.tv_nsec);
}

}  // namespace sinew

#endif  // SINEW_COMMON_THREAD_SECONDS_H_
