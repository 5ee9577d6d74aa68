#include "teacher/client/part_queue.h"

#include <optional>
#include <thread>
#include <vector>

#include "absl/status/status.h"
#include "absl/time/time.h"
#include "common/testing/matchers.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "teacher/client/testing/part_queue_rig.h"

namespace sinew::teacher {
namespace {

using ::sinew::testing::IsOk;
using ::sinew::testing::StatusIs;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Optional;
using Rig = testing::PartQueueRig;

// back since.
void FailPart0(Rig& rig, int replica, int times, const absl::Status& status) {
  for (int i = 0; i < times; ++i) {
    ASSERT_THAT(rig.queue.Take(replica), Optional(0)) << i;
    rig.queue.Failed(replica, 0, status);
    rig.clock.Advance(absl::Seconds(20));  // beyond every back-off
    if (!rig.health.ReadyFrom(replica).has_value()) rig.Come(replica);
  }
}

TEST(PartQueue, HandsOutEveryPartOnce) {
  Rig rig(3, 2);

  EXPECT_THAT(rig.queue.Take(0), Optional(0));
  EXPECT_THAT(rig.queue.Take(1), Optional(1));
  EXPECT_THAT(rig.queue.Take(0), Optional(2));
  EXPECT_TRUE(rig.queue.Done(0, 0));
  EXPECT_TRUE(rig.queue.Done(1, 1));
  EXPECT_TRUE(rig.queue.Done(0, 2));

  EXPECT_EQ(rig.queue.Take(0), std::nullopt);
  EXPECT_THAT(rig.queue.Await({}), IsOk());
}

TEST(PartQueue, EndsForAllWhenToldTo) {
  Rig rig(3, 2);
  ASSERT_THAT(rig.queue.Take(0), Optional(0));

  rig.queue.End(absl::InvalidArgumentError("row 4"));
  rig.queue.End(absl::InvalidArgumentError("row 5"));

  EXPECT_EQ(rig.queue.Take(0), std::nullopt);
  EXPECT_EQ(rig.queue.Take(1), std::nullopt);
  EXPECT_THAT(rig.queue.Await({}),
              StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr("row 4")));
}

TEST(PartQueue, LeavesAFailedPartToAReplicaThatIsWell) {
  Rig rig(2, 2);
  ASSERT_THAT(rig.queue.Take(0), Optional(0));
  rig.queue.Failed(0, 0, absl::UnavailableError("teacher a: away"));

  // Once it is back, a takes the other part.
  rig.Come(0);
  EXPECT_THAT(rig.queue.Take(0), Optional(1));
  EXPECT_THAT(rig.queue.Take(1), Optional(0));
}

TEST(PartQueue, AsksTheSameReplicaAgainAfterABackOffIfThereIsNoOther) {
  Rig rig(1, 1);
  ASSERT_THAT(rig.queue.Take(0), Optional(0));
  rig.queue.Failed(0, 0, absl::ResourceExhaustedError("teacher a: full"));
  std::optional<int64_t> again;

  std::jthread worker([&] { again = rig.queue.Take(0); });
  ASSERT_TRUE(rig.clock.AwaitWaiters(1));
  rig.clock.Advance(absl::Milliseconds(1001));
  worker.join();

  EXPECT_THAT(again, Optional(0));
}

TEST(PartQueue, AsksAnotherReplicaForWhatOneRefuses) {
  Rig rig(2, 2);
  ASSERT_NO_FATAL_FAILURE(
      FailPart0(rig, /*replica=*/0, /*times=*/1,
                absl::InvalidArgumentError("teacher a: nan")));
  // b does not answer for now, yet a never has that part again.
  ASSERT_NO_FATAL_FAILURE(FailPart0(rig, /*replica=*/1, /*times=*/1,
                                    absl::UnavailableError("teacher b: away")));

  EXPECT_THAT(rig.queue.Take(0), Optional(1));
  rig.queue.Done(0, 1);
  EXPECT_THAT(rig.queue.Take(1), Optional(0));
  rig.queue.Done(1, 0);
  EXPECT_THAT(rig.queue.Await({}), IsOk());
}

TEST(PartQueue, EndsWithARefusalOnceEveryReplicaRefuses) {
  Rig rig(2, 2);
  ASSERT_NO_FATAL_FAILURE(
      FailPart0(rig, /*replica=*/0, /*times=*/1,
                absl::InvalidArgumentError("teacher a: nan")));
  ASSERT_NO_FATAL_FAILURE(
      FailPart0(rig, /*replica=*/1, /*times=*/1,
                absl::InvalidArgumentError("teacher b: nan")));

  EXPECT_EQ(rig.queue.Take(0), std::nullopt);
  EXPECT_THAT(rig.queue.Await({}), StatusIs(absl::StatusCode::kInvalidArgument,
                                            HasSubstr("teacher b: nan")));
}

TEST(PartQueue, EndsWithTheRefusalOfTheOnlyReplica) {
  Rig rig(2, 1);
  ASSERT_THAT(rig.queue.Take(0), Optional(0));

  rig.queue.Failed(0, 0, absl::InvalidArgumentError("teacher a: nan"));

  EXPECT_EQ(rig.queue.Take(0), std::nullopt);
  EXPECT_THAT(rig.queue.Await({}), StatusIs(absl::StatusCode::kInvalidArgument,
                                            HasSubstr("teacher a: nan")));
}

TEST(PartQueue, EndsWithARefusalWhenTheOthersGoOut) {
  Rig rig(2, 2);
  ASSERT_THAT(rig.queue.Take(1), Optional(0));
  ASSERT_THAT(rig.queue.Take(0), Optional(1));
  rig.queue.Failed(0, 1, absl::InvalidArgumentError("teacher a: nan"));

  // Part 1 had b alone left.
  rig.queue.Failed(1, 0, absl::FailedPreconditionError("teacher b: bundle"));

  EXPECT_EQ(rig.queue.Take(0), std::nullopt);
  EXPECT_THAT(rig.queue.Await({}), StatusIs(absl::StatusCode::kInvalidArgument,
                                            HasSubstr("teacher a: nan")));
}

TEST(PartQueue, EndsAsInternalWhenSomeRefuseAndSomeAnswerWrongly) {
  Rig rig(1, 2);
  ASSERT_NO_FATAL_FAILURE(
      FailPart0(rig, /*replica=*/1, /*times=*/1,
                absl::InvalidArgumentError("teacher b: nan")));
  ASSERT_NO_FATAL_FAILURE(FailPart0(rig, /*replica=*/0, /*times=*/3,
                                    absl::DataLossError("teacher a: short")));

  EXPECT_THAT(
      rig.queue.Await({}),
      StatusIs(absl::StatusCode::kInternal,
               AllOf(HasSubstr("3 wrong answers from every teacher that there "
                               "is and does not refuse it"),
                     HasSubstr("the last: teacher a: short"))));
}

TEST(PartQueue, DropsAReplicaThatServesSomethingElse) {
  Rig rig(1, 2);
  ASSERT_THAT(rig.queue.Take(0), Optional(0));
  rig.queue.Failed(0, 0, absl::FailedPreconditionError("teacher a: bundle"));

  EXPECT_EQ(rig.queue.Take(0), std::nullopt);
  ASSERT_THAT(rig.queue.Take(1), Optional(0));
  rig.queue.Failed(1, 0, absl::FailedPreconditionError("teacher b: bundle"));

  EXPECT_THAT(rig.queue.Await({}),
              StatusIs(absl::StatusCode::kFailedPrecondition,
                       HasSubstr("teacher b: bundle")));
}

TEST(PartQueue, LeavesNothingToAReplicaThatIsOut) {
  Rig rig(3, 2);
  // Of a's two calls one is refused for good, the other still comes through.
  ASSERT_THAT(rig.queue.Take(0), Optional(0));
  ASSERT_THAT(rig.queue.Take(0), Optional(1));
  ASSERT_THAT(rig.queue.Take(1), Optional(2));
  rig.queue.Failed(0, 0, absl::FailedPreconditionError("teacher a: bundle"));
  rig.queue.Done(0, 1);
  rig.Come(0);

  rig.queue.Failed(1, 2, absl::UnavailableError("teacher b: away"));
  rig.clock.Advance(absl::Seconds(2));
  rig.Come(1);

  EXPECT_THAT(rig.queue.Take(1), Optional(2));
  EXPECT_THAT(rig.queue.Take(1), Optional(0));
}

TEST(PartQueue, EndsAfterThreeWrongAnswersPerReplica) {
  Rig rig(1, 2);
  for (int i = 0; i < 6; ++i) {
    ASSERT_NO_FATAL_FAILURE(
        FailPart0(rig, /*replica=*/i % 2, /*times=*/1,
                  absl::DataLossError("targets: found nan")));
  }

  EXPECT_EQ(rig.queue.Take(0), std::nullopt);
  EXPECT_THAT(
      rig.queue.Await({}),
      StatusIs(absl::StatusCode::kInternal,
               HasSubstr("3 wrong answers from every teacher that there "
                         "is, the last: targets: found")));
}

TEST(PartQueue, BarsAReplicaFromAPartThatItAnswersWronglyThreeTimes) {
  Rig rig(2, 2);
  // b is away, a has part 0 alone.
  ASSERT_THAT(rig.queue.Take(1), Optional(0));
  rig.queue.Failed(1, 0, absl::UnavailableError("teacher b: away"));
  ASSERT_NO_FATAL_FAILURE(
      FailPart0(rig, /*replica=*/0, /*times=*/3,
                absl::DataLossError("teacher a: found nan")));

  // Only b may have it any more.
  rig.Come(1);
  EXPECT_THAT(rig.queue.Take(0), Optional(1));
  rig.queue.Done(0, 1);
  EXPECT_THAT(rig.queue.Take(1), Optional(0));
  rig.queue.Done(1, 0);
  EXPECT_THAT(rig.queue.Await({}), IsOk());
}

TEST(PartQueue, TakesABrokenConnectionForNoAnswer) {
  Rig rig(1, 1);
  ASSERT_NO_FATAL_FAILURE(
      FailPart0(rig, /*replica=*/0, /*times=*/5,
                absl::InternalError("teacher a: RST_STREAM")));

  ASSERT_THAT(rig.queue.Take(0), Optional(0));
  rig.queue.Done(0, 0);
  EXPECT_THAT(rig.queue.Await({}), IsOk());
}

TEST(PartQueue, EndsWithAWrongAnswerWhenTheOthersServeSomethingElse) {
  Rig rig(1, 2);
  ASSERT_THAT(rig.queue.Take(1), Optional(0));
  rig.queue.Failed(1, 0, absl::FailedPreconditionError("teacher b: bundle"));
  ASSERT_NO_FATAL_FAILURE(
      FailPart0(rig, /*replica=*/0, /*times=*/3,
                absl::DataLossError("teacher a: found nan")));

  EXPECT_THAT(rig.queue.Await({}), StatusIs(absl::StatusCode::kInternal,
                                            HasSubstr("teacher a: found nan")));
}

TEST(PartQueue, EndsWhenNoIntroductionFindsTheTeacher) {
  Rig rig(1, 2);
  const auto away = absl::UnavailableError("teacher a: away");
  rig.queue.Introduced(0, away);
  rig.queue.Introduced(0, absl::FailedPreconditionError("teacher a: bundle"));
  rig.queue.Introduced(1, away);
  ASSERT_THAT(rig.queue.Take(1), Optional(0));

  rig.queue.Introduced(1, absl::FailedPreconditionError("teacher b: bundle"));

  EXPECT_EQ(rig.queue.Take(0), std::nullopt);
  EXPECT_THAT(rig.queue.Await({}),
              StatusIs(absl::StatusCode::kFailedPrecondition,
                       HasSubstr("teacher b: bundle")));
}

// What Await says once 60 s have passed.
absl::Status RunOutOfPatience(Rig& rig) {
  absl::Status status;
  std::jthread waiter([&] { status = rig.queue.Await({}); });
  rig.clock.AwaitWaiters(1);
  rig.clock.Advance(absl::Seconds(61));
  waiter.join();
  return status;
}

TEST(PartQueue, NamesAllPeersWhenPatienceEnds) {
  Rig rig(2, 2);
  ASSERT_THAT(rig.queue.Take(0), Optional(0));
  rig.queue.Done(0, 0);
  ASSERT_THAT(rig.queue.Take(0), Optional(1));
  rig.queue.Failed(0, 1, absl::UnavailableError("teacher a: away"));

  EXPECT_THAT(
      RunOutOfPatience(rig),
      StatusIs(absl::StatusCode::kUnavailable,
               AllOf(HasSubstr("1 of 2 parts"), HasSubstr("teacher a: away"),
                     HasSubstr("teacher b: no error"))));
}

TEST(PartQueue, SaysThatAllWereLateIfThatIsWhatHappened) {
  Rig rig(1, 1);
  ASSERT_THAT(rig.queue.Take(0), Optional(0));
  rig.queue.Failed(0, 0, absl::DeadlineExceededError("teacher a: late"));

  EXPECT_THAT(RunOutOfPatience(rig),
              StatusIs(absl::StatusCode::kDeadlineExceeded,
                       HasSubstr("teacher a: late")));
}

TEST(PartQueue, EndsWhenStopped) {
  Rig rig(1, 1);
  std::stop_source stop;
  stop.request_stop();

  EXPECT_THAT(rig.queue.Await(stop.get_token()),
              StatusIs(absl::StatusCode::kCancelled));
  EXPECT_EQ(rig.queue.Take(0), std::nullopt);
}

}  // namespace
}  // namespace sinew::teacher
