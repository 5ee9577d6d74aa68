#include "common/testing/allocation_count.h"

#include <atomic>
#include <cstdlib>
#include <new>

#if defined(__has_feature)
#if __has_feature(thread_sanitizer)
#define SINEW_THREAD_SANITIZER
#include <sanitizer/allocator_interface.h>
#endif
#endif

namespace {

std::atomic<int64_t> allocations = 0;

#ifdef SINEW_THREAD_SANITIZER

// Its runtime defines operator new itself, and no program may beside it.
void CountAllocation(const volatile void*, size_t) { ++allocations; }
void IgnoreFree(const volatile void*) {}
[[maybe_unused]] const int hooks =
    __sanitizer_install_malloc_and_free_hooks(CountAllocation, IgnoreFree);

}  // namespace

#else

void* Allocate(std::size_t size) {
  ++allocations;
  void* memory = std::malloc(size == 0 ? 1 : size);
  if (memory == nullptr) std::abort();
  return memory;
}

}  // namespace

void* operator new(std::size_t size) { return Allocate(size); }
void* operator new[](std::size_t size) { return Allocate(size); }
void operator delete(void* memory) noexcept { std::free(memory); }
void operator delete[](void* memory) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }
void operator delete[](void* memory, std::size_t) noexcept {
  std::free(memory);
}

#endif  // SINEW_THREAD_SANITIZER

namespace sinew::testing {

int64_t AllocationCount() { return allocations; }

}  // namespace sinew::testing
