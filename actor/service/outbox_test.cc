#include "actor/service/outbox.h"

#include <chrono>
#include <cstdint>
#include <memory>
#include <stop_token>
#include <string>
#include <thread>

#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace sinew::actor {
namespace {

using ::testing::ElementsAre;

OutgoingPtr MakeOutgoing(int64_t order_id, size_t size = 10) {
  auto segment = std::make_shared<OutgoingSegment>();
  segment->order_id = order_id;
  segment->bytes = std::string(size, 'x');
  return segment;
}

// What the sender would send next.
int64_t SendNext(Outbox& outbox) {
  std::stop_source stop;
  stop.request_stop();
  const OutgoingPtr next = outbox.NextUnsent(stop.get_token());
  return next == nullptr ? -1 : next->order_id;
}

TEST(Outbox, KeepsSegmentsUntilTheirVerdict) {
  Outbox outbox(100);
  ASSERT_TRUE(outbox.Push(MakeOutgoing(1)));
  ASSERT_TRUE(outbox.Push(MakeOutgoing(2)));

  EXPECT_EQ(SendNext(outbox), 1);
  EXPECT_EQ(outbox.bytes(), 20);
  EXPECT_EQ(outbox.Acknowledge(1)->order_id, 1);
  EXPECT_EQ(outbox.bytes(), 10);
  EXPECT_EQ(SendNext(outbox), 2);
  EXPECT_EQ(SendNext(outbox), -1);
}

TEST(Outbox, SendsAgainWhatHadNoVerdictWhenTheStreamBroke) {
  Outbox outbox(100);
  for (int64_t id : {1, 2, 3}) ASSERT_TRUE(outbox.Push(MakeOutgoing(id)));
  EXPECT_EQ(SendNext(outbox), 1);
  EXPECT_EQ(SendNext(outbox), 2);
  ASSERT_NE(outbox.Acknowledge(1), nullptr);

  outbox.Rewind();

  EXPECT_EQ(SendNext(outbox), 2);
  EXPECT_EQ(SendNext(outbox), 3);
}

TEST(Outbox, KnowsAVerdictThatIsNotTheNext) {
  Outbox outbox(100);
  ASSERT_TRUE(outbox.Push(MakeOutgoing(1)));

  EXPECT_EQ(outbox.Acknowledge(1), nullptr);  // not sent
  EXPECT_EQ(SendNext(outbox), 1);
  EXPECT_EQ(outbox.Acknowledge(2), nullptr);
}

TEST(Outbox, BlocksWorkersUntilThereIsRoom) {
  Outbox outbox(20);
  ASSERT_TRUE(outbox.Push(MakeOutgoing(1, 15)));
  std::jthread worker([&outbox] {
    EXPECT_TRUE(outbox.Push(MakeOutgoing(2, 15)));
    EXPECT_LE(outbox.bytes(), 20);
  });

  EXPECT_EQ(SendNext(outbox), 1);
  ASSERT_NE(outbox.Acknowledge(1), nullptr);
}

TEST(Outbox, LetsASegmentPassThatIsLargerThanItsBound) {
  Outbox outbox(20);

  EXPECT_TRUE(outbox.Push(MakeOutgoing(1, 50)));
}

TEST(Outbox, SaysWhatIsLeftWhenItCloses) {
  Outbox outbox(20);
  ASSERT_TRUE(outbox.Push(MakeOutgoing(1, 15)));
  std::jthread worker(
      [&outbox] { EXPECT_FALSE(outbox.Push(MakeOutgoing(2, 15))); });

  EXPECT_FALSE(outbox.WaitUntilEmpty(std::chrono::steady_clock::now()));
  EXPECT_THAT(outbox.Close(), ElementsAre(1));
}

}  // namespace
}  // namespace sinew::actor
