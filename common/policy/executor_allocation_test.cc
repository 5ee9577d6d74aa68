// Counts what the program takes from the heap: a program of its own, since it
// replaces operator new.
#include "common/policy/executor.h"
#include "common/policy/testing/examples.h"
#include "common/testing/allocation_count.h"
#include "common/testing/matchers.h"
#include "gtest/gtest.h"

namespace sinew::policy {
namespace {

using ::sinew::policy::testing::AllExamples;
using ::sinew::policy::testing::Example;
using ::sinew::testing::IsOk;

TEST(ExecutorAllocation, NeitherRunNorNewWeightsTouchTheHeap) {
  for (const Example& example : AllExamples()) {
    auto pack =
        *PackWeights(example.graph, example.graph_name, example.weights);
    auto next =
        *PackWeights(example.graph, example.graph_name, example.weights);
    auto executor = *Executor::Create(pack, 13);
    pack.reset();
    const int64_t before = sinew::testing::AllocationCount();
    ASSERT_GT(before, 0);

    executor->Run(13);
    const absl::Status status = executor->SetWeights(next);
    executor->Run(2);

    EXPECT_EQ(sinew::testing::AllocationCount() - before, 0) << example.name;
    EXPECT_THAT(status, IsOk());
  }
}

}  // namespace
}  // namespace sinew::policy
