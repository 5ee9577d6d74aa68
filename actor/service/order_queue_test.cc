#include "actor/service/order_queue.h"

#include <optional>
#include <thread>

#include "absl/status/status.h"
#include "common/testing/matchers.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace sinew::actor {
namespace {

using ::sinew::testing::IsOk;
using ::sinew::testing::StatusIs;
using ::testing::ElementsAre;

v1::Order MakeOrder(int64_t id) {
  v1::Order order;
  order.set_order_id(id);
  return order;
}

TEST(OrderQueue, GivesOrdersInTheirOrder) {
  OrderQueue queue(2);
  ASSERT_THAT(queue.Push(MakeOrder(1)), IsOk());
  ASSERT_THAT(queue.Push(MakeOrder(2)), IsOk());

  EXPECT_EQ(queue.Pop()->order_id(), 1);
  EXPECT_EQ(queue.Pop()->order_id(), 2);
}

TEST(OrderQueue, IsBounded) {
  OrderQueue queue(1);
  ASSERT_THAT(queue.Push(MakeOrder(1)), IsOk());

  EXPECT_THAT(queue.Push(MakeOrder(2)),
              StatusIs(absl::StatusCode::kResourceExhausted));
}

TEST(OrderQueue, WakesWhoWaitsWhenItCloses) {
  OrderQueue queue(1);
  std::jthread worker([&queue] { EXPECT_EQ(queue.Pop(), std::nullopt); });

  queue.Close();

  EXPECT_THAT(queue.Push(MakeOrder(1)),
              StatusIs(absl::StatusCode::kFailedPrecondition));
}

TEST(OrderQueue, GivesBackWhatNobodyBegan) {
  OrderQueue queue(3);
  for (int64_t id : {1, 2, 3}) ASSERT_THAT(queue.Push(MakeOrder(id)), IsOk());
  queue.Pop();

  EXPECT_THAT(queue.Clear(), ElementsAre(2, 3));
  queue.Close();
  EXPECT_EQ(queue.Pop(), std::nullopt);
}

}  // namespace
}  // namespace sinew::actor
