#include "learner/dispatcher/order_pool.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace sinew::learner {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

constexpr int64_t kFirst = 1, kSecond = 2, kThird = 3;
constexpr int64_t kFirstIssue = 40;
const absl::Time kStart = absl::UnixEpoch();
const absl::Duration kLate = absl::Seconds(20);

std::vector<v1::Order> MakeOrders(std::initializer_list<int64_t> ids) {
  std::vector<v1::Order> orders;
  for (int64_t id : ids) orders.emplace_back().set_order_id(id);
  return orders;
}

int64_t AssignedId(OrderPool& pool, int64_t actor, absl::Time now) {
  auto order = pool.Assign(actor, now);
  return order ? order->order_id() : -1;
}

TEST(OrderPool, HandsOutOrdersByRisingId) {
  OrderPool pool(kLate, kFirstIssue);
  pool.Add(MakeOrders({7, 3, 5}));

  EXPECT_EQ(AssignedId(pool, kFirst, kStart), 3);
  EXPECT_EQ(AssignedId(pool, kSecond, kStart), 5);
  EXPECT_EQ(AssignedId(pool, kFirst, kStart), 7);
  EXPECT_EQ(AssignedId(pool, kFirst, kStart), -1);
  EXPECT_EQ(pool.waiting(), 0);
  EXPECT_EQ(pool.leased(), 3);
}

TEST(OrderPool, GivesALateOrderToAnotherActorOnly) {
  OrderPool pool(kLate, kFirstIssue);
  pool.Add(MakeOrders({1}));
  ASSERT_EQ(AssignedId(pool, kFirst, kStart), 1);

  EXPECT_EQ(AssignedId(pool, kSecond, kStart + kLate / 2), -1);
  EXPECT_EQ(AssignedId(pool, kFirst, kStart + kLate), -1);
  EXPECT_EQ(AssignedId(pool, kSecond, kStart + kLate), 1);
  EXPECT_EQ(pool.reissued(), 1);
  // A third actor waits for the second's lease to be late, too.
  EXPECT_EQ(AssignedId(pool, kThird, kStart + kLate * 3 / 2), -1);
  EXPECT_EQ(AssignedId(pool, kThird, kStart + kLate * 2), 1);
}

TEST(OrderPool, NeverHandsOutAFinishedOrderAgain) {
  OrderPool pool(kLate, kFirstIssue);
  pool.Add(MakeOrders({1}));
  ASSERT_EQ(AssignedId(pool, kFirst, kStart), 1);

  pool.Finish(kFirst, 1, kFirstIssue);

  EXPECT_EQ(AssignedId(pool, kSecond, kStart + kLate * 2), -1);
  EXPECT_EQ(pool.leased(), 0);
}

TEST(OrderPool, NumbersEveryAddingOfAnOrder) {
  OrderPool pool(kLate, kFirstIssue);
  pool.Add(MakeOrders({1, 2}));
  EXPECT_EQ(pool.Assign(kFirst, kStart)->issue(), 40);
  EXPECT_EQ(pool.Assign(kFirst, kStart)->issue(), 41);

  pool.Add(MakeOrders({1}));

  EXPECT_EQ(pool.Assign(kFirst, kStart)->issue(), 42);
}

TEST(OrderPool, ALateAnswerDoesNotFinishAnOrderThatWasAddedAgain) {
  OrderPool pool(kLate, kFirstIssue);
  pool.Add(MakeOrders({1}));
  ASSERT_EQ(AssignedId(pool, kFirst, kStart), 1);
  pool.Add(MakeOrders({1}));  // replay has forgotten it

  pool.Finish(kFirst, 1, kFirstIssue);

  EXPECT_EQ(pool.waiting(), 1);
  ASSERT_EQ(AssignedId(pool, kFirst, kStart), 1);

  // Nor does it end the lease that the same actor has by now.
  pool.Finish(kFirst, 1, kFirstIssue);
  EXPECT_EQ(pool.held_by(kFirst), 1);
  pool.Finish(kFirst, 1, kFirstIssue + 1);
  EXPECT_EQ(pool.held_by(kFirst), 0);
  EXPECT_EQ(AssignedId(pool, kSecond, kStart + kLate * 2), -1);
}

TEST(OrderPool, AnAnswerFinishesAnOrderThatTheActorHoldsNoMore) {
  OrderPool pool(kLate, kFirstIssue);
  pool.Add(MakeOrders({1}));
  ASSERT_EQ(AssignedId(pool, kFirst, kStart), 1);
  pool.Forget(kFirst);  // its stream broke; the segment went on to replay

  pool.Finish(kSecond, 1, kFirstIssue);  // its next stream

  EXPECT_EQ(pool.waiting(), 0);
  EXPECT_EQ(AssignedId(pool, kSecond, kStart), -1);
}

TEST(OrderPool, PutsOrdersOfALostActorBack) {
  OrderPool pool(kLate, kFirstIssue);
  pool.Add(MakeOrders({1, 2}));
  ASSERT_EQ(AssignedId(pool, kFirst, kStart), 1);
  ASSERT_EQ(AssignedId(pool, kFirst, kStart), 2);

  pool.Forget(kFirst);

  EXPECT_EQ(pool.waiting(), 2);
  EXPECT_EQ(AssignedId(pool, kSecond, kStart), 1);
}

TEST(OrderPool, KeepsAReturnedOrderLeasedWhileAnotherActorHoldsIt) {
  OrderPool pool(kLate, kFirstIssue);
  pool.Add(MakeOrders({1}));
  ASSERT_EQ(AssignedId(pool, kFirst, kStart), 1);
  ASSERT_EQ(AssignedId(pool, kSecond, kStart + kLate), 1);

  pool.Return(kFirst, 1);

  EXPECT_EQ(pool.waiting(), 0);
  EXPECT_EQ(pool.held_by(kSecond), 1);
  pool.Return(kSecond, 1);
  EXPECT_EQ(pool.waiting(), 1);
}

TEST(OrderPool, IgnoresAnswersForRetiredOrders) {
  OrderPool pool(kLate, kFirstIssue);
  pool.Add(MakeOrders({1}));
  ASSERT_EQ(AssignedId(pool, kFirst, kStart), 1);
  pool.Retire({1});

  pool.Finish(kFirst, 1, kFirstIssue);
  pool.Return(kFirst, 1);
  pool.Forget(kFirst);

  EXPECT_EQ(pool.waiting(), 0);
  EXPECT_EQ(pool.leased(), 0);
}

TEST(OrderPool, KnowsWhichOrdersAreFinishedUntilTheyAreAddedAgain) {
  OrderPool pool(kLate, kFirstIssue);
  pool.Add(MakeOrders({1, 2, 3}));
  for (const int64_t id : {1, 2, 3}) {
    ASSERT_EQ(AssignedId(pool, kFirst, kStart), id);
  }
  pool.Finish(kFirst, 3, kFirstIssue + 2);
  pool.Finish(kFirst, 1, kFirstIssue);
  EXPECT_THAT(pool.finished(), ElementsAre(1, 3));

  pool.Add(MakeOrders({1}));
  pool.Retire({3});

  EXPECT_THAT(pool.finished(), IsEmpty());
  EXPECT_EQ(AssignedId(pool, kFirst, kStart), 1);
}

}  // namespace
}  // namespace sinew::learner
