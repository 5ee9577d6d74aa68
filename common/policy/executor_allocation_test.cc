// Counts what the program takes from the heap: a program of its own, since it
// replaces operator new.
#include <atomic>
#include <cstdlib>
#include <new>

#include "common/policy/executor.h"
#include "common/policy/testing/examples.h"
#include "common/testing/matchers.h"
#include "gtest/gtest.h"

namespace {

std::atomic<int64_t> allocations = 0;

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

namespace sinew::policy {
namespace {

using ::sinew::policy::testing::AllExamples;
using ::sinew::policy::testing::Example;
using ::sinew::testing::IsOk;

TEST(ExecutorAllocation, CountsAllocations) {
  const int64_t before = allocations;

  auto memory = std::make_unique<std::string>(100, 'x');

  EXPECT_GE(allocations - before, 2);
}

TEST(ExecutorAllocation, NeitherRunNorNewWeightsTouchTheHeap) {
  for (const Example& example : AllExamples()) {
    auto pack =
        *PackWeights(example.graph, example.graph_name, example.weights);
    auto next =
        *PackWeights(example.graph, example.graph_name, example.weights);
    auto executor = *Executor::Create(pack, 13);
    pack.reset();
    const int64_t before = allocations;

    executor->Run(13);
    const absl::Status status = executor->SetWeights(next);
    executor->Run(2);

    EXPECT_EQ(allocations - before, 0) << example.name;
    EXPECT_THAT(status, IsOk());
  }
}

}  // namespace
}  // namespace sinew::policy
