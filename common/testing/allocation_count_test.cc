#include "common/testing/allocation_count.h"

#include <gtest/gtest.h>

#include <memory>
#include <string>

namespace sinew::testing {
namespace {

TEST(AllocationCount, CountsObjectsAndWhatTheyAllocate) {
  const int64_t before = AllocationCount();

  auto memory = std::make_unique<std::string>(100, 'x');

  EXPECT_GE(AllocationCount() - before, 2);
}

TEST(AllocationCount, StandsStillWhereNothingIsAllocated) {
  std::string text(100, 'x');
  const int64_t before = AllocationCount();

  text[50] = 'y';

  EXPECT_EQ(AllocationCount() - before, 0);
}

}  // namespace
}  // namespace sinew::testing
