// How an actor ends, and what it does while its learner is away.
#include <memory>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "absl/time/time.h"
#include "actor/service/actor.h"
#include "actor/service/testing/actor_fixture.h"
#include "common/testing/matchers.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "replay/testing/test_replay.h"

namespace sinew::actor {
namespace {

using ::sinew::testing::IsOk;
using ::sinew::testing::StatusIs;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::SizeIs;
using ::testing::UnorderedElementsAre;

class ActorLifetimeTest : public ActorFixture {};

TEST_F(ActorLifetimeTest, FinishesWhatRunsAndGivesBackTheRestWhenStopped) {
  Learner learner(folder_.Address("l"));
  engine_.Hold();
  Start(learner);
  for (int64_t id : {1, 2, 3, 4}) learner.Add(id);
  engine_.WaitUntilHeld(2);
  learner.dispatcher().WaitForWanted(0);

  stop_.request_stop();
  learner.dispatcher().WaitForReturned(2);
  engine_.Release();

  EXPECT_THAT(End(), IsOk());
  EXPECT_THAT(learner.dispatcher().returned(), UnorderedElementsAre(3, 4));
  EXPECT_THAT(learner.dispatcher().done(), UnorderedElementsAre(1, 2));
}

TEST_F(ActorLifetimeTest, GivesBackWhatItCannotFinishInTime) {
  Learner learner(folder_.Address("l"));
  engine_.Hold();
  Actor::Options options = Options(learner.address());
  options.drain_timeout = absl::Milliseconds(10);
  Start(options);
  for (int64_t id : {1, 2}) learner.Add(id);
  engine_.WaitUntilHeld(2);

  EXPECT_THAT(StopAndEnd(), IsOk());

  learner.dispatcher().WaitForReturned(2);
  EXPECT_THAT(learner.dispatcher().returned(), UnorderedElementsAre(1, 2));
}

TEST_F(ActorLifetimeTest, GivesBackSegmentsThatReplayDoesNotTakeInTime) {
  // Room for one segment, which is taken by another writer.
  Learner learner(folder_.Address("l"), replay::TestReplay::SegmentBytes());
  const auto other = learner.replay().OccupyRoom(9);
  Actor::Options options = Options(learner.address());
  options.drain_timeout = absl::Milliseconds(10);
  Start(options);
  learner.Add(1, /*iteration=*/1);
  learner.dispatcher().WaitForGiven(1);
  learner.dispatcher().WaitForWanted(4);

  EXPECT_THAT(StopAndEnd(), IsOk());

  learner.dispatcher().WaitForReturned(1);
  EXPECT_THAT(learner.dispatcher().returned(), ElementsAre(1));
}

TEST_F(ActorLifetimeTest, FinishesEverythingWhenTheLearnerDrains) {
  Learner learner(folder_.Address("l"));
  engine_.Hold();
  Start(learner);
  for (int64_t id : {1, 2, 3, 4}) learner.Add(id);
  learner.dispatcher().WaitForGiven(4);

  learner.dispatcher().Drain();
  engine_.Release();

  EXPECT_THAT(End(), IsOk());
  EXPECT_THAT(learner.dispatcher().done(), UnorderedElementsAre(1, 2, 3, 4));
  EXPECT_THAT(learner.dispatcher().returned(), SizeIs(0));
}

TEST_F(ActorLifetimeTest, ComesBackToALearnerThatWasRestarted) {
  auto first = std::make_unique<Learner>(folder_.Address("l"));
  Start(*first);
  first->Add(1);
  EXPECT_THAT(first->Take({1}), IsOk());

  first.reset();
  Learner second(folder_.Address("l"));
  second.Add(2);

  EXPECT_THAT(second.Take({2}), IsOk());
  second.dispatcher().WaitForDone(1);
  EXPECT_GT(metrics_.reconnects.Value(), 0);
}

TEST_F(ActorLifetimeTest, WaitsForALearnerThatIsNotUpYet) {
  Start(Options(folder_.Address("l")));

  Learner learner(folder_.Address("l"));
  learner.Add(1);

  EXPECT_THAT(learner.Take({1}), IsOk());
}

TEST_F(ActorLifetimeTest, EndsWithAnErrorThatNamesTheLearnerThatStaysAway) {
  auto learner = std::make_unique<Learner>(folder_.Address("l"));
  Actor::Options options = Options(learner->address());
  options.reconnect_timeout = absl::Milliseconds(50);
  Start(options);
  learner->Add(1);
  EXPECT_THAT(learner->Take({1}), IsOk());

  learner.reset();

  EXPECT_THAT(
      End(),
      StatusIs(absl::StatusCode::kUnavailable,
               HasSubstr(absl::StrCat("no learner at ", folder_.Address("l"),
                                      " for 50ms; last error: "))));
}

TEST_F(ActorLifetimeTest, AsksForAsManyOrdersAsBeforeAfterALostStream) {
  auto first = std::make_unique<Learner>(folder_.Address("l"));
  engine_.Hold();
  Start(*first);
  for (int64_t id : {1, 2, 3}) first->Add(id);
  engine_.WaitUntilHeld(2);
  first->dispatcher().WaitForWanted(1);

  first.reset();
  Learner second(folder_.Address("l"));
  // Two of four places are taken by orders 1 and 2, which still run.
  second.dispatcher().WaitForWanted(2);
  engine_.Release();

  second.dispatcher().WaitForWanted(4);
  second.dispatcher().WaitForDone(2);
}

TEST_F(ActorLifetimeTest, EndsAtOnceWhenStoppedWhileTheLearnerIsAway) {
  auto learner = std::make_unique<Learner>(folder_.Address("l"));
  engine_.Hold();
  Actor::Options options = Options(learner->address());
  options.drain_timeout = absl::Hours(1);
  Start(options);
  for (int64_t id : {1, 2}) learner->Add(id);
  engine_.WaitUntilHeld(2);
  learner.reset();
  Learner other(folder_.Address("l"));
  other.dispatcher().Refuse(absl::UnavailableError("not yet"));
  other.dispatcher().WaitForRegistered(1);

  // Though orders 1 and 2 still run.
  EXPECT_THAT(StopAndEnd(), IsOk());
}

TEST_F(ActorLifetimeTest, EndsWhenItIsRefused) {
  Learner learner(folder_.Address("l"));
  learner.dispatcher().Refuse(
      absl::FailedPreconditionError("build: expected a, found build"));
  Start(learner);

  EXPECT_THAT(End(), StatusIs(absl::StatusCode::kFailedPrecondition,
                              HasSubstr("build: expected a, found build")));
}

TEST_F(ActorLifetimeTest, StopsWhileNobodyAnswers) {
  Start(Options(folder_.Address("nobody")));

  EXPECT_THAT(StopAndEnd(), IsOk());
}

}  // namespace
}  // namespace sinew::actor
