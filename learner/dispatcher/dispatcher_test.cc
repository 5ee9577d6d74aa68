#include "learner/dispatcher/dispatcher.h"

#include <cmath>
#include <thread>

#include "absl/status/status.h"
#include "absl/time/time.h"
#include "common/testing/matchers.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "learner/dispatcher/testing/dispatcher_fixture.h"
#include "learner/dispatcher/testing/dispatcher_rig.h"

namespace sinew::learner {
namespace {

using ::sinew::testing::StatusIs;
using ::testing::HasSubstr;
using ::testing::Optional;

class DispatcherTest : public DispatcherFixture {};

TEST_F(DispatcherTest, WelcomesAnActorOfItsOwnBuild) {
  TestActor actor(rig_, "a");

  const auto welcome = actor.Register(MakeRegister("a"));

  ASSERT_TRUE(welcome.ok()) << welcome.status();
  EXPECT_EQ(welcome->run_id(), "run");
  EXPECT_EQ(welcome->heartbeat_seconds(), 10);
  EXPECT_EQ(dispatcher_.statistics().actors, 1);
  EXPECT_EQ(dispatcher_.statistics().threads, 2);
}

TEST_F(DispatcherTest, TellsAnActorOfAnotherBuildWhyItMayNotJoin) {
  TestActor actor(rig_, "a");
  v1::ActorMessage::Register request = MakeRegister("host/7");
  request.set_build("b2");

  EXPECT_THAT(actor.Register(request),
              StatusIs(absl::StatusCode::kFailedPrecondition,
                       HasSubstr("actor host/7: build: expected b1, "
                                 "found b2")));
  EXPECT_EQ(dispatcher_.statistics().refused_actors, 1);
  EXPECT_EQ(dispatcher_.statistics().actors, 0);
}

TEST_F(DispatcherTest, RefusesAStreamThatDoesNotRegisterFirst) {
  TestActor actor(rig_, "a");

  actor.Want(1);

  EXPECT_THAT(actor.ReadEnd(),
              StatusIs(absl::StatusCode::kFailedPrecondition,
                       HasSubstr("expected register as first message")));
}

TEST_F(DispatcherTest, RefusesMessagesOutOfTurn) {
  TestActor eager(rig_, "eager"), odd(rig_, "odd");
  eager.Join();
  odd.Join();
  v1::ActorMessage again;
  *again.mutable_register_() = MakeRegister("eager");

  eager.Send(again);
  odd.Want(0);

  EXPECT_THAT(eager.ReadEnd(), StatusIs(absl::StatusCode::kInvalidArgument,
                                        HasSubstr("after register")));
  EXPECT_THAT(odd.ReadEnd(),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("want.count: expected >= 1, found 0")));
}

TEST_F(DispatcherTest, GivesAnActorAsManyOrdersAsItWants) {
  dispatcher_.Add(MakeOrders({1, 2, 3}));
  TestActor actor(rig_, "a");
  actor.Join();

  actor.Want(2);
  EXPECT_THAT(actor.ReadOrder(), Optional(1));
  EXPECT_THAT(actor.ReadOrder(), Optional(2));
  EXPECT_EQ(dispatcher_.statistics().orders_waiting, 1);
  EXPECT_EQ(dispatcher_.statistics().orders_leased, 2);

  actor.Done(1);
  actor.Want(1);
  EXPECT_THAT(actor.ReadOrder(), Optional(3));
}

TEST_F(DispatcherTest, SharesNewOrdersAmongActorsThatWait) {
  TestActor first(rig_, "first"), second(rig_, "second");
  for (TestActor* actor : {&first, &second}) {
    actor->Join();
    actor->Want(2);
    actor->Sync();
  }

  dispatcher_.Add(MakeOrders({1, 2, 3, 4}));

  EXPECT_THAT(first.ReadOrder(), Optional(1));
  EXPECT_THAT(second.ReadOrder(), Optional(2));
  EXPECT_THAT(first.ReadOrder(), Optional(3));
  EXPECT_THAT(second.ReadOrder(), Optional(4));
}

TEST_F(DispatcherTest, ForgetsRetiredOrders) {
  dispatcher_.Add(MakeOrders({1, 2}));
  dispatcher_.Retire({1});
  TestActor actor(rig_, "a");
  actor.Join();

  actor.Want(1);

  EXPECT_THAT(actor.ReadOrder(), Optional(2));
}

TEST_F(DispatcherTest, ReportsWhatActorsSayOfTime) {
  TestActor actor(rig_, "a");
  actor.Join();
  v1::ActorMessage message;
  message.mutable_done()->set_applied_version(7);
  message.mutable_done()->set_apply_seconds(0.25);
  message.mutable_done()->set_idle_seconds(2);
  message.mutable_done()->set_blocked_seconds(-std::nan(""));

  actor.Send(message);
  actor.Send(message);  // the version is known: no second observation
  actor.Send(message);
  message.mutable_done()->set_applied_version(8);
  message.mutable_done()->set_apply_seconds(0.5);
  actor.Send(message);

  rig_.AwaitApplied(0.5, 1);
  rig_.AwaitApplied(0.25, 1);
  EXPECT_EQ(dispatcher_.statistics().applied_version, 8);
  EXPECT_EQ(dispatcher_.statistics().apply_seconds, 0.5);
  EXPECT_EQ(dispatcher_.statistics().idle_seconds, 8);
  EXPECT_EQ(dispatcher_.statistics().blocked_seconds, 0);
}

TEST_F(DispatcherTest, EndsTheStreamOfAnIdleActorAfterDrain) {
  TestActor actor(rig_, "a");
  actor.Join();
  std::jthread end([this] { dispatcher_.Shutdown(absl::InfiniteFuture()); });

  EXPECT_TRUE(actor.ReadDrain());
  EXPECT_THAT(actor.ReadEnd(), StatusIs(absl::StatusCode::kOutOfRange));
}

TEST_F(DispatcherTest, LetsADrainedActorFinishWhatItHolds) {
  dispatcher_.Add(MakeOrders({1, 2}));
  TestActor actor(rig_, "a");
  actor.Join();
  actor.Want(2);
  ASSERT_THAT(actor.ReadOrder(), Optional(1));
  ASSERT_THAT(actor.ReadOrder(), Optional(2));
  std::jthread end([this] { dispatcher_.Shutdown(absl::InfiniteFuture()); });
  ASSERT_TRUE(actor.ReadDrain());

  actor.Want(1);  // gets nothing any more
  actor.Done(1);
  actor.Return({2});

  EXPECT_THAT(actor.ReadEnd(), StatusIs(absl::StatusCode::kOutOfRange));
  EXPECT_EQ(dispatcher_.statistics().lost_actors, 0);
}

TEST_F(DispatcherTest, EndsStreamsAtTheDeadlineOfShutdown) {
  dispatcher_.Add(MakeOrders({1}));
  TestActor busy(rig_, "busy");
  busy.Join();
  busy.Want(1);
  ASSERT_THAT(busy.ReadOrder(), Optional(1));
  std::jthread end(
      [this] { dispatcher_.Shutdown(clock_.WallNow() + absl::Seconds(9)); });
  ASSERT_TRUE(busy.ReadDrain());
  ASSERT_TRUE(clock_.AwaitWaiters(2));  // the ticker and Shutdown

  clock_.Advance(absl::Seconds(9));

  EXPECT_THAT(busy.ReadEnd(), StatusIs(absl::StatusCode::kUnavailable,
                                       HasSubstr("going away")));
  end.join();
  EXPECT_EQ(dispatcher_.statistics().lost_actors, 1);
}

// So an actor comes back: it was not told to go.
TEST_F(DispatcherTest, EndsStreamsWithoutADrainWhereItIsInterrupted) {
  dispatcher_.Add(MakeOrders({1}));
  TestActor busy(rig_, "busy");
  busy.Join();
  busy.Want(1);
  ASSERT_THAT(busy.ReadOrder(), Optional(1));

  dispatcher_.Interrupt();

  EXPECT_THAT(busy.ReadEnd(), StatusIs(absl::StatusCode::kUnavailable,
                                       HasSubstr("going away")));
  TestActor late(rig_, "late");
  EXPECT_THAT(late.Register(MakeRegister("late")),
              StatusIs(absl::StatusCode::kUnavailable));
}

TEST_F(DispatcherTest, AdmitsNobodyAfterShutdown) {
  dispatcher_.Shutdown(absl::InfiniteFuture());
  TestActor late(rig_, "late");

  EXPECT_THAT(
      late.Register(MakeRegister("late")),
      StatusIs(absl::StatusCode::kUnavailable, HasSubstr("going away")));
}

}  // namespace
}  // namespace sinew::learner
