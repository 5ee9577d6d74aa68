#ifndef SINEW_COMMON_TESTING_ALLOCATION_COUNT_H_
#define SINEW_COMMON_TESTING_ALLOCATION_COUNT_H_

#include <cstdint>

namespace sinew::testing {

// Times that this program's operator new was called so far, by all threads.
// Who links this library has its operator new and delete replaced by counting
// ones (malloc and free behind them); over-aligned ones are not counted. Under
// thread sanitizer, whose operator new stays, every malloc counts.
// Thread-safe; never blocks.
int64_t AllocationCount();

}  // namespace sinew::testing

#endif  // SINEW_COMMON_TESTING_ALLOCATION_COUNT_H_
