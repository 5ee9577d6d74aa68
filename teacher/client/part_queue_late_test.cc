// Replicas that are away or slow, within a batch and from one to the next.
#include <optional>
#include <thread>

#include "absl/status/status.h"
#include "absl/time/time.h"
#include "common/testing/matchers.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "teacher/client/part_queue.h"
#include "teacher/client/testing/part_queue_rig.h"

namespace sinew::teacher {
namespace {

using ::sinew::testing::IsOk;
using ::sinew::testing::StatusIs;
using ::testing::HasSubstr;
using ::testing::Optional;
using Rig = testing::PartQueueRig;

TEST(PartQueue, GivesNothingToAReplicaThatHasNotBeenIntroducedAgain) {
  Rig rig(2, 2);
  ASSERT_THAT(rig.queue.Take(0), Optional(0));
  rig.queue.Failed(0, 0, absl::UnavailableError("teacher a: away"));
  rig.clock.Advance(absl::Seconds(20));  // beyond its back-off
  std::optional<int64_t> taken;

  std::jthread worker([&] { taken = rig.queue.Take(0); });
  ASSERT_TRUE(rig.clock.AwaitWaiters(1));
  ASSERT_THAT(rig.queue.Take(1), Optional(0));
  rig.Come(0);
  worker.join();

  EXPECT_THAT(taken, Optional(1));
}

TEST(PartQueue, KnowsWhoIsAwayFromTheBatchBefore) {
  Rig rig(1, 2);
  ASSERT_THAT(rig.queue.Take(0), Optional(0));
  rig.queue.Failed(0, 0, absl::UnavailableError("teacher a: away"));
  PartQueue next(testing::MakeOptions(1, 2), rig.health, rig.clock);
  rig.clock.Advance(absl::Seconds(20));  // beyond its back-off
  std::optional<int64_t> taken = 0;

  std::jthread worker([&] { taken = next.Take(0); });
  ASSERT_TRUE(rig.clock.AwaitWaiters(1));
  ASSERT_THAT(next.Take(1), Optional(0));
  EXPECT_TRUE(next.Done(1, 0));
  worker.join();

  EXPECT_EQ(taken, std::nullopt);
}

TEST(PartQueue, GivesALatePartToAReplicaThatHasNothingElseToDo) {
  Rig rig(2, 2);
  ASSERT_THAT(rig.queue.Take(0), Optional(0));
  ASSERT_THAT(rig.queue.Take(1), Optional(1));
  rig.queue.Done(1, 1);
  std::optional<int64_t> taken;

  std::jthread worker([&] { taken = rig.queue.Take(1); });
  ASSERT_TRUE(rig.clock.AwaitWaiters(1));
  rig.clock.Advance(absl::Milliseconds(1001));
  worker.join();

  EXPECT_THAT(taken, Optional(0));
  EXPECT_EQ(rig.health.ReadyFrom(0), std::nullopt);
  EXPECT_THAT(rig.health.LastError(0),
              StatusIs(absl::StatusCode::kDeadlineExceeded,
                       HasSubstr("teacher a: no answer after 1.001s")));
}

TEST(PartQueue, LeavesAPartWhereItIsUntilItIsLate) {
  Rig rig(1, 2);
  ASSERT_THAT(rig.queue.Take(0), Optional(0));
  rig.clock.Advance(absl::Milliseconds(999));
  std::optional<int64_t> taken = 0;

  std::jthread worker([&] { taken = rig.queue.Take(1); });
  ASSERT_TRUE(rig.clock.AwaitWaiters(1));
  EXPECT_TRUE(rig.queue.Done(0, 0));
  worker.join();

  EXPECT_EQ(taken, std::nullopt);
}

TEST(PartQueue, CallsNothingLateThatTheOtherOneWouldTakeAsLongFor) {
  Rig rig(3, 2);
  ASSERT_THAT(rig.queue.Take(1), Optional(0));
  rig.clock.Advance(absl::Seconds(2));  // so late is after 4 * 2 s
  rig.queue.Done(1, 0);
  ASSERT_THAT(rig.queue.Take(0), Optional(1));
  rig.clock.Advance(absl::Seconds(2));
  ASSERT_THAT(rig.queue.Take(0), Optional(2));
  rig.clock.Advance(absl::Milliseconds(6001));

  // Part 2 has been out for 6 s.
  EXPECT_THAT(rig.queue.Take(1), Optional(1));
}

TEST(PartQueue, UsesTheFirstAnswerToAPartAlone) {
  Rig rig(1, 2);
  ASSERT_THAT(rig.queue.Take(0), Optional(0));
  rig.clock.Advance(absl::Seconds(2));
  ASSERT_THAT(rig.queue.Take(1), Optional(0));

  EXPECT_TRUE(rig.queue.Done(1, 0));
  EXPECT_FALSE(rig.queue.Done(0, 0));

  EXPECT_THAT(rig.queue.Await({}), IsOk());
}

TEST(PartQueue, LeavesAPartToWhoeverStillHasIt) {
  Rig rig(2, 2);
  ASSERT_THAT(rig.queue.Take(0), Optional(0));
  ASSERT_THAT(rig.queue.Take(1), Optional(1));
  rig.queue.Done(1, 1);
  rig.clock.Advance(absl::Seconds(20));
  ASSERT_THAT(rig.queue.Take(1), Optional(0));

  rig.queue.Failed(1, 0, absl::DataLossError("teacher b: found nan"));

  EXPECT_TRUE(rig.queue.Done(0, 0));
  EXPECT_THAT(rig.queue.Await({}), IsOk());
}

TEST(PartQueue, IgnoresTheFailureOfWhoeverHasBeenOvertaken) {
  Rig rig(1, 2);
  ASSERT_THAT(rig.queue.Take(0), Optional(0));
  rig.clock.Advance(absl::Seconds(2));
  ASSERT_THAT(rig.queue.Take(1), Optional(0));

  EXPECT_TRUE(rig.queue.Done(1, 0));
  rig.queue.Failed(0, 0, absl::InvalidArgumentError("teacher a: nan"));

  EXPECT_THAT(rig.queue.Await({}), IsOk());
}

}  // namespace
}  // namespace sinew::teacher
