#include "teacher/client/replica_health.h"

#include <optional>
#include <stop_token>
#include <thread>

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
using ::testing::HasSubstr;
using ::testing::Optional;

// Two replicas; waits of 1, 2, 4 s ... up to 8 s.
ReplicaHealth::Options MakeOptions() {
  return {.replicas = 2,
          .backoff = {.initial = absl::Seconds(1),
                      .longest = absl::Seconds(8),
                      .factor = 2,
                      .jitter = 0},
          .late_factor = 4,
          .late_floor = absl::Seconds(1)};
}

const absl::Status kAway = absl::UnavailableError("teacher a: away");

TEST(ReplicaHealth, GivesRowsToThoseThatWereIntroduced) {
  SimulatedClock clock;
  ReplicaHealth health(MakeOptions(), clock);

  health.Introduced(1);

  EXPECT_EQ(health.ReadyFrom(0), std::nullopt);
  EXPECT_FALSE(health.IsWell(0));
  EXPECT_THAT(health.ReadyFrom(1), Optional(clock.SteadyNow()));
  EXPECT_TRUE(health.IsWell(1));
}

TEST(ReplicaHealth, WantsAnIntroductionOfOneThatHasFailed) {
  SimulatedClock clock;
  ReplicaHealth health(MakeOptions(), clock);
  health.Introduced(0);

  health.Failed(0, kAway);

  EXPECT_EQ(health.ReadyFrom(0), std::nullopt);
  EXPECT_FALSE(health.IsWell(0));
  // A part of before it failed says nothing of what is there now.
  health.Answered(0, absl::Seconds(1));
  EXPECT_EQ(health.ReadyFrom(0), std::nullopt);
  EXPECT_THAT(health.LastError(0), StatusIs(absl::StatusCode::kUnavailable));
  health.Introduced(0);
  EXPECT_THAT(health.ReadyFrom(0), Optional(clock.SteadyNow()));
  EXPECT_TRUE(health.IsWell(0));
}

TEST(ReplicaHealth, LetsOneThatIsFullOrWrongWait) {
  SimulatedClock clock;
  ReplicaHealth health(MakeOptions(), clock);
  health.Introduced(0);
  health.Introduced(1);

  health.Failed(0, absl::ResourceExhaustedError("teacher a: full"));
  health.Failed(1, absl::DataLossError("teacher b: found nan"));

  for (const int replica : {0, 1}) {
    EXPECT_THAT(health.ReadyFrom(replica),
                Optional(clock.After(absl::Seconds(1))));
    EXPECT_FALSE(health.IsWell(replica));
  }
  health.Answered(0, absl::Seconds(1));
  EXPECT_TRUE(health.IsWell(0));
  EXPECT_THAT(health.LastError(0), IsOk());
  EXPECT_THAT(health.LastError(1), StatusIs(absl::StatusCode::kDataLoss,
                                            HasSubstr("teacher b: found")));
}

TEST(ReplicaHealth, CallsAPartLateByTheUsualTimeOfWhoeverWouldTakeItOver) {
  SimulatedClock clock;
  ReplicaHealth health(MakeOptions(), clock);

  EXPECT_EQ(health.LateAfter(0), absl::Seconds(1));
  health.Answered(0, absl::Milliseconds(100));
  EXPECT_EQ(health.LateAfter(0), absl::Seconds(1));
  health.Answered(1, absl::Seconds(1));
  EXPECT_EQ(health.LateAfter(1), absl::Seconds(4));
  health.Answered(1, absl::Seconds(2));
  EXPECT_EQ(health.LateAfter(1), 4 * absl::Milliseconds(1200));
  EXPECT_EQ(health.LateAfter(0), absl::Seconds(1));
}

// Whether its turn comes exactly `wait` from now.
void ExpectTurnAfter(ReplicaHealth& health, SimulatedClock& clock,
                     absl::Duration wait) {
  const auto turn = clock.After(wait);
  std::jthread waiter([&] { EXPECT_TRUE(health.AwaitTurn(0, {})); });
  ASSERT_TRUE(clock.AwaitWaiters(1));
  clock.Advance(wait);
  waiter.join();
  EXPECT_EQ(clock.SteadyNow(), turn);
}

TEST(ReplicaHealth, AsksEverLessForAnIntroductionUntilRowsAreAnswered) {
  SimulatedClock clock;
  ReplicaHealth health(MakeOptions(), clock);
  EXPECT_TRUE(health.AwaitTurn(0, {}));

  for (const int seconds : {1, 2, 4, 8, 8}) {
    health.Failed(0, kAway);
    ExpectTurnAfter(health, clock, absl::Seconds(seconds));
    health.Introduced(0);
  }
  health.Answered(0, absl::Seconds(1));
  health.Failed(0, kAway);
  ExpectTurnAfter(health, clock, absl::Seconds(1));
}

TEST(ReplicaHealth, WaitsForAFailureOrTheEnd) {
  SimulatedClock clock;
  ReplicaHealth health(MakeOptions(), clock);
  health.Introduced(0);
  std::stop_source stop;
  bool turn = true;

  std::jthread waiter([&] { turn = health.AwaitTurn(0, stop.get_token()); });
  ASSERT_TRUE(clock.AwaitWaiters(1));
  clock.Advance(absl::Hours(2));
  ASSERT_TRUE(clock.AwaitWaiters(1));
  stop.request_stop();
  waiter.join();

  EXPECT_FALSE(turn);
}

}  // namespace
}  // namespace sinew::teacher
