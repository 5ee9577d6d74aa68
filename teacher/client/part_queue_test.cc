#include "teacher/client/part_queue.h"

#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "absl/status/status.h"
#include "absl/time/time.h"
#include "common/testing/matchers.h"
#include "common/testing/simulated_clock.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace sinew::teacher {
namespace {

using ::sinew::testing::IsOk;
using ::sinew::testing::SimulatedClock;
using ::sinew::testing::StatusIs;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Optional;

PartQueue::Options MakeOptions(int64_t parts, int replicas) {
  PartQueue::Options options;
  options.parts = parts;
  for (int i = 0; i < replicas; ++i) {
    options.peers.push_back(std::string("teacher ") +
                            static_cast<char>('a' + i));
  }
  options.backoff = {.initial = absl::Seconds(1), .jitter = 0};
  options.patience = absl::Seconds(60);
  return options;
}

// Part 0, taken by a replica and failed, `times` times in a row.
void FailPart0(PartQueue& queue, SimulatedClock& clock, int replica, int times,
               const absl::Status& status) {
  for (int i = 0; i < times; ++i) {
    ASSERT_THAT(queue.Take(replica), Optional(0)) << i;
    queue.Failed(replica, 0, status);
    clock.Advance(absl::Seconds(20));  // beyond every back-off
  }
}

TEST(PartQueue, HandsOutEveryPartOnce) {
  SimulatedClock clock;
  PartQueue queue(MakeOptions(3, 2), clock);

  EXPECT_THAT(queue.Take(0), Optional(0));
  EXPECT_THAT(queue.Take(1), Optional(1));
  EXPECT_THAT(queue.Take(0), Optional(2));
  queue.Done(0);
  queue.Done(1);
  queue.Done(0);

  EXPECT_EQ(queue.Take(0), std::nullopt);
  EXPECT_THAT(queue.Await({}), IsOk());
}

TEST(PartQueue, EndsForAllWhenToldTo) {
  SimulatedClock clock;
  PartQueue queue(MakeOptions(3, 2), clock);
  ASSERT_THAT(queue.Take(0), Optional(0));

  queue.End(absl::InvalidArgumentError("row 4"));
  queue.End(absl::InvalidArgumentError("row 5"));

  EXPECT_EQ(queue.Take(0), std::nullopt);
  EXPECT_EQ(queue.Take(1), std::nullopt);
  EXPECT_THAT(queue.Await({}),
              StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr("row 4")));
}

TEST(PartQueue, LeavesAFailedPartToAReplicaThatIsWell) {
  SimulatedClock clock;
  PartQueue queue(MakeOptions(2, 2), clock);
  ASSERT_THAT(queue.Take(0), Optional(0));
  queue.Failed(0, 0, absl::UnavailableError("teacher a: away"));

  // After its back-off, a takes the other part.
  clock.Advance(absl::Seconds(2));
  EXPECT_THAT(queue.Take(0), Optional(1));
  EXPECT_THAT(queue.Take(1), Optional(0));
}

TEST(PartQueue, AsksTheSameReplicaAgainAfterABackOffIfThereIsNoOther) {
  SimulatedClock clock;
  PartQueue queue(MakeOptions(1, 1), clock);
  ASSERT_THAT(queue.Take(0), Optional(0));
  queue.Failed(0, 0, absl::ResourceExhaustedError("teacher a: full"));
  std::optional<int64_t> again;

  std::jthread worker([&] { again = queue.Take(0); });
  ASSERT_TRUE(clock.AwaitWaiters(1));
  clock.Advance(absl::Milliseconds(1001));
  worker.join();

  EXPECT_THAT(again, Optional(0));
}

TEST(PartQueue, AsksAnotherReplicaForWhatOneRefuses) {
  SimulatedClock clock;
  PartQueue queue(MakeOptions(2, 2), clock);
  ASSERT_NO_FATAL_FAILURE(
      FailPart0(queue, clock, /*replica=*/0, /*times=*/1,
                absl::InvalidArgumentError("teacher a: nan")));
  // b does not answer for now, yet a never has that part again.
  ASSERT_NO_FATAL_FAILURE(FailPart0(queue, clock, /*replica=*/1, /*times=*/1,
                                    absl::UnavailableError("teacher b: away")));

  EXPECT_THAT(queue.Take(0), Optional(1));
  queue.Done(0);
  EXPECT_THAT(queue.Take(1), Optional(0));
  queue.Done(1);
  EXPECT_THAT(queue.Await({}), IsOk());
}

TEST(PartQueue, EndsWithARefusalOnceEveryReplicaRefuses) {
  SimulatedClock clock;
  PartQueue queue(MakeOptions(2, 2), clock);
  ASSERT_NO_FATAL_FAILURE(
      FailPart0(queue, clock, /*replica=*/0, /*times=*/1,
                absl::InvalidArgumentError("teacher a: nan")));
  ASSERT_NO_FATAL_FAILURE(
      FailPart0(queue, clock, /*replica=*/1, /*times=*/1,
                absl::InvalidArgumentError("teacher b: nan")));

  EXPECT_EQ(queue.Take(0), std::nullopt);
  EXPECT_THAT(queue.Await({}), StatusIs(absl::StatusCode::kInvalidArgument,
                                        HasSubstr("teacher b: nan")));
}

TEST(PartQueue, EndsWithTheRefusalOfTheOnlyReplica) {
  SimulatedClock clock;
  PartQueue queue(MakeOptions(2, 1), clock);
  ASSERT_THAT(queue.Take(0), Optional(0));

  queue.Failed(0, 0, absl::InvalidArgumentError("teacher a: nan"));

  EXPECT_EQ(queue.Take(0), std::nullopt);
  EXPECT_THAT(queue.Await({}), StatusIs(absl::StatusCode::kInvalidArgument,
                                        HasSubstr("teacher a: nan")));
}

TEST(PartQueue, EndsWithARefusalWhenTheOthersGoOut) {
  SimulatedClock clock;
  PartQueue queue(MakeOptions(2, 2), clock);
  ASSERT_THAT(queue.Take(1), Optional(0));
  ASSERT_THAT(queue.Take(0), Optional(1));
  queue.Failed(0, 1, absl::InvalidArgumentError("teacher a: nan"));

  // Part 1 had b alone left.
  queue.Failed(1, 0, absl::FailedPreconditionError("teacher b: bundle"));

  EXPECT_EQ(queue.Take(0), std::nullopt);
  EXPECT_THAT(queue.Await({}), StatusIs(absl::StatusCode::kInvalidArgument,
                                        HasSubstr("teacher a: nan")));
}

TEST(PartQueue, EndsAsInternalWhenSomeRefuseAndSomeAnswerWrongly) {
  SimulatedClock clock;
  PartQueue queue(MakeOptions(1, 2), clock);
  ASSERT_NO_FATAL_FAILURE(
      FailPart0(queue, clock, /*replica=*/1, /*times=*/1,
                absl::InvalidArgumentError("teacher b: nan")));
  ASSERT_NO_FATAL_FAILURE(FailPart0(queue, clock, /*replica=*/0, /*times=*/3,
                                    absl::DataLossError("teacher a: short")));

  EXPECT_THAT(
      queue.Await({}),
      StatusIs(absl::StatusCode::kInternal,
               AllOf(HasSubstr("3 wrong answers from every teacher that there "
                               "is and does not refuse it"),
                     HasSubstr("the last: teacher a: short"))));
}

TEST(PartQueue, DropsAReplicaThatServesSomethingElse) {
  SimulatedClock clock;
  PartQueue queue(MakeOptions(1, 2), clock);
  ASSERT_THAT(queue.Take(0), Optional(0));
  queue.Failed(0, 0, absl::FailedPreconditionError("teacher a: bundle"));

  EXPECT_EQ(queue.Take(0), std::nullopt);
  ASSERT_THAT(queue.Take(1), Optional(0));
  queue.Failed(1, 0, absl::FailedPreconditionError("teacher b: bundle"));

  EXPECT_THAT(queue.Await({}), StatusIs(absl::StatusCode::kFailedPrecondition,
                                        HasSubstr("teacher b: bundle")));
}

TEST(PartQueue, LeavesNothingToAReplicaThatIsOut) {
  SimulatedClock clock;
  PartQueue queue(MakeOptions(3, 2), clock);
  // Of a's two calls one is refused for good, the other still comes through.
  ASSERT_THAT(queue.Take(0), Optional(0));
  ASSERT_THAT(queue.Take(0), Optional(1));
  ASSERT_THAT(queue.Take(1), Optional(2));
  queue.Failed(0, 0, absl::FailedPreconditionError("teacher a: bundle"));
  queue.Done(0);

  queue.Failed(1, 2, absl::UnavailableError("teacher b: away"));
  clock.Advance(absl::Seconds(2));

  EXPECT_THAT(queue.Take(1), Optional(2));
  EXPECT_THAT(queue.Take(1), Optional(0));
}

TEST(PartQueue, EndsAfterThreeWrongAnswersPerReplica) {
  SimulatedClock clock;
  PartQueue queue(MakeOptions(1, 2), clock);
  for (int i = 0; i < 6; ++i) {
    ASSERT_NO_FATAL_FAILURE(
        FailPart0(queue, clock, /*replica=*/i % 2, /*times=*/1,
                  absl::DataLossError("targets: found nan")));
  }

  EXPECT_EQ(queue.Take(0), std::nullopt);
  EXPECT_THAT(
      queue.Await({}),
      StatusIs(absl::StatusCode::kInternal,
               HasSubstr("3 wrong answers from every teacher that there "
                         "is, the last: targets: found")));
}

TEST(PartQueue, BarsAReplicaFromAPartThatItAnswersWronglyThreeTimes) {
  SimulatedClock clock;
  PartQueue queue(MakeOptions(2, 2), clock);
  // b is away, a has part 0 alone.
  ASSERT_THAT(queue.Take(1), Optional(0));
  queue.Failed(1, 0, absl::UnavailableError("teacher b: away"));
  ASSERT_NO_FATAL_FAILURE(
      FailPart0(queue, clock, /*replica=*/0, /*times=*/3,
                absl::DataLossError("teacher a: found nan")));

  // Only b may have it any more, though it is not well either.
  EXPECT_THAT(queue.Take(0), Optional(1));
  queue.Done(0);
  EXPECT_THAT(queue.Take(1), Optional(0));
  queue.Done(1);
  EXPECT_THAT(queue.Await({}), IsOk());
}

TEST(PartQueue, TakesABrokenConnectionForNoAnswer) {
  SimulatedClock clock;
  PartQueue queue(MakeOptions(1, 1), clock);
  ASSERT_NO_FATAL_FAILURE(
      FailPart0(queue, clock, /*replica=*/0, /*times=*/5,
                absl::InternalError("teacher a: RST_STREAM")));

  ASSERT_THAT(queue.Take(0), Optional(0));
  queue.Done(0);
  EXPECT_THAT(queue.Await({}), IsOk());
}

TEST(PartQueue, EndsWithAWrongAnswerWhenTheOthersServeSomethingElse) {
  SimulatedClock clock;
  PartQueue queue(MakeOptions(1, 2), clock);
  ASSERT_THAT(queue.Take(1), Optional(0));
  queue.Failed(1, 0, absl::FailedPreconditionError("teacher b: bundle"));
  ASSERT_NO_FATAL_FAILURE(
      FailPart0(queue, clock, /*replica=*/0, /*times=*/3,
                absl::DataLossError("teacher a: found nan")));

  EXPECT_THAT(queue.Await({}), StatusIs(absl::StatusCode::kInternal,
                                        HasSubstr("teacher a: found nan")));
}

// What Await says once 60 s have passed.
absl::Status RunOutOfPatience(PartQueue& queue, SimulatedClock& clock) {
  absl::Status status;
  std::jthread waiter([&] { status = queue.Await({}); });
  clock.AwaitWaiters(1);
  clock.Advance(absl::Seconds(61));
  waiter.join();
  return status;
}

TEST(PartQueue, NamesAllPeersWhenPatienceEnds) {
  SimulatedClock clock;
  PartQueue queue(MakeOptions(2, 2), clock);
  ASSERT_THAT(queue.Take(0), Optional(0));
  queue.Done(0);
  ASSERT_THAT(queue.Take(0), Optional(1));
  queue.Failed(0, 1, absl::UnavailableError("teacher a: away"));

  EXPECT_THAT(
      RunOutOfPatience(queue, clock),
      StatusIs(absl::StatusCode::kUnavailable,
               AllOf(HasSubstr("1 of 2 parts"), HasSubstr("teacher a: away"),
                     HasSubstr("teacher b: no error"))));
}

TEST(PartQueue, SaysThatAllWereLateIfThatIsWhatHappened) {
  SimulatedClock clock;
  PartQueue queue(MakeOptions(1, 1), clock);
  ASSERT_THAT(queue.Take(0), Optional(0));
  queue.Failed(0, 0, absl::DeadlineExceededError("teacher a: late"));

  EXPECT_THAT(RunOutOfPatience(queue, clock),
              StatusIs(absl::StatusCode::kDeadlineExceeded,
                       HasSubstr("teacher a: late")));
}

TEST(PartQueue, EndsWhenStopped) {
  SimulatedClock clock;
  PartQueue queue(MakeOptions(1, 1), clock);
  std::stop_source stop;
  stop.request_stop();

  EXPECT_THAT(queue.Await(stop.get_token()),
              StatusIs(absl::StatusCode::kCancelled));
  EXPECT_EQ(queue.Take(0), std::nullopt);
}

}  // namespace
}  // namespace sinew::teacher
