#include "actor/testing/order_allocations.h"

#include <gtest/gtest.h>

#include "common/testing/allocation_count.h"

namespace sinew::actor::testing {

int64_t OrderAllocations(RolloutRig& rig, int horizon) {
  const v1::Order order = rig.StandingOrder(1, horizon);
  rig.Run(order);
  const int64_t before = sinew::testing::AllocationCount();
  const v1::Segment segment = rig.Run(order);
  EXPECT_EQ(segment.episodes_size(), 0);
  return sinew::testing::AllocationCount() - before;
}

}  // namespace sinew::actor::testing
