#include "learner/dispatcher/dispatcher.h"

#include <chrono>
#include <cmath>
#include <cstdint>
#include <set>
#include <thread>
#include <vector>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "absl/time/time.h"
#include "common/clock.h"
#include "common/mutex.h"
#include "common/testing/matchers.h"
#include "common/testing/simulated_clock.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "learner/dispatcher/testing/dispatcher_rig.h"

namespace sinew::learner {
namespace {

using ::sinew::testing::SimulatedClock;
using ::sinew::testing::StatusIs;
using ::testing::HasSubstr;
using ::testing::Optional;

// Heartbeat 10 s: silent for more than 30 s is lost; late at 20 s.
class DispatcherTest : public ::testing::Test {
 protected:
  // Once the ticker waits: it then sees the new time.
  void Advance(absl::Duration duration) {
    ASSERT_TRUE(clock_.AwaitWaiters(1));
    clock_.Advance(duration);
  }

  SimulatedClock clock_;
  DispatcherRig rig_{clock_};
  Dispatcher& dispatcher_ = rig_.dispatcher();
};

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

TEST_F(DispatcherTest, HandsTheOrdersOfASilentActorToAnother) {
  dispatcher_.Add(MakeOrders({1}));
  TestActor silent(rig_, "silent"), other(rig_, "other");
  silent.Join();
  silent.Want(1);
  ASSERT_THAT(silent.ReadOrder(), Optional(1));
  Advance(absl::Seconds(15));
  other.Join();
  other.Want(1);
  other.Sync();

  Advance(absl::Seconds(16));  // silent for 31 s, the other for 16 s

  EXPECT_THAT(other.ReadOrder(), Optional(1));
  EXPECT_THAT(silent.ReadEnd(), StatusIs(absl::StatusCode::kUnavailable,
                                         HasSubstr("no heartbeat for 30s")));
  EXPECT_EQ(dispatcher_.statistics().lost_actors, 1);
  EXPECT_EQ(dispatcher_.statistics().actors, 1);
}

TEST_F(DispatcherTest, KeepsTheLeasesOfAnActorWhoseHeartBeats) {
  dispatcher_.Add(MakeOrders({1}));
  TestActor actor(rig_, "a");
  actor.Join();
  actor.Want(1);
  ASSERT_THAT(actor.ReadOrder(), Optional(1));

  for (int i = 0; i < 3; ++i) {
    Advance(absl::Seconds(20));
    actor.Heartbeat();
    actor.Sync();
  }

  EXPECT_EQ(dispatcher_.statistics().lost_actors, 0);
  EXPECT_EQ(dispatcher_.statistics().orders_leased, 1);
}

TEST_F(DispatcherTest, IssuesALateOrderAgainWhileTheFirstActorLives) {
  dispatcher_.Add(MakeOrders({1}));
  TestActor slow(rig_, "slow"), idle(rig_, "idle");
  slow.Join();
  slow.Want(1);
  ASSERT_THAT(slow.ReadOrder(), Optional(1));
  idle.Join();
  idle.Want(1);
  idle.Sync();

  Advance(absl::Seconds(20));

  EXPECT_THAT(idle.ReadOrder(), Optional(1));
  EXPECT_EQ(dispatcher_.statistics().orders_reissued, 1);
  EXPECT_EQ(dispatcher_.statistics().actors, 2);
  EXPECT_EQ(dispatcher_.statistics().lost_actors, 0);
}

TEST_F(DispatcherTest, HandsAReturnedOrderToAnother) {
  dispatcher_.Add(MakeOrders({1, 2}));
  TestActor leaving(rig_, "leaving"), other(rig_, "other");
  leaving.Join();
  leaving.Want(2);
  ASSERT_THAT(leaving.ReadOrder(), Optional(1));
  ASSERT_THAT(leaving.ReadOrder(), Optional(2));
  other.Join();
  other.Want(1);

  leaving.Return({2, 77});

  EXPECT_THAT(other.ReadOrder(), Optional(2));
  EXPECT_EQ(dispatcher_.statistics().orders_returned, 1);
}

TEST_F(DispatcherTest, GivesARefusedOrderOutTwiceMoreAndThenFails) {
  dispatcher_.Add(MakeOrders({1}));
  TestActor actor(rig_, "a");
  actor.Join();

  for (const char* reason : {"first", "second", "NON_FINITE: reward"}) {
    EXPECT_EQ(dispatcher_.failure(), absl::OkStatus());
    actor.Want(1);
    ASSERT_THAT(actor.ReadOrder(), Optional(1));
    actor.Refuse(1, reason);
    actor.Sync();
  }

  EXPECT_THAT(dispatcher_.failure(),
              StatusIs(absl::StatusCode::kFailedPrecondition,
                       HasSubstr("order 1: replay refused its segment 3 times, "
                                 "the last time with NON_FINITE: reward")));
}

TEST_F(DispatcherTest, IgnoresTheRefusalOfAnOrderThatHasASegment) {
  dispatcher_.Add(MakeOrders({1}));
  TestActor actor(rig_, "a");
  actor.Join();
  actor.Want(1);
  ASSERT_THAT(actor.ReadOrder(), Optional(1));
  actor.Done(1);

  for (int i = 0; i < 3; ++i) actor.Refuse(1, "late");
  actor.Sync();

  EXPECT_EQ(dispatcher_.failure(), absl::OkStatus());
  EXPECT_EQ(dispatcher_.statistics().orders_waiting, 0);
}

TEST_F(DispatcherTest, ALateDoneDoesNotFinishAnOrderThatWasAddedAgain) {
  dispatcher_.Add(MakeOrders({1}));
  TestActor actor(rig_, "a");
  actor.Join();
  actor.Want(1);
  ASSERT_THAT(actor.ReadOrder(), Optional(1));
  dispatcher_.Add(MakeOrders({1}));  // replay was started again

  actor.Done(1);  // what the replay of before has answered
  actor.Sync();

  EXPECT_EQ(dispatcher_.statistics().orders_waiting, 1);
  actor.Want(1);
  EXPECT_THAT(actor.ReadOrder(), Optional(1));
  actor.Done(1);
  actor.Sync();
  EXPECT_EQ(dispatcher_.statistics().orders_leased, 0);
  EXPECT_EQ(dispatcher_.statistics().orders_waiting, 0);
}

TEST_F(DispatcherTest, AnActorsAnswerToAnEarlierLearnerFinishesNothing) {
  v1::Order before;
  {
    DispatcherRig earlier(clock_);
    earlier.dispatcher().Add(MakeOrders({1}));
    TestActor actor(earlier, "a");
    actor.Join();
    actor.Want(1);
    const auto message = actor.stream().Read();
    ASSERT_TRUE(message.ok()) << message.status();
    before = message->order();
  }
  clock_.Advance(absl::Seconds(1));
  DispatcherRig later(clock_);
  later.dispatcher().Add(MakeOrders({1}));
  TestActor actor(later, "a");
  actor.Join();

  actor.Done(before);
  actor.Sync();

  EXPECT_EQ(later.dispatcher().statistics().orders_waiting, 1);
}

TEST_F(DispatcherTest, HandsTheOrdersOfABrokenStreamToAnother) {
  dispatcher_.Add(MakeOrders({1}));
  TestActor other(rig_, "other");
  other.Join();
  {
    TestActor killed(rig_, "killed");
    killed.Join();
    killed.Want(1);
    ASSERT_THAT(killed.ReadOrder(), Optional(1));
    other.Want(1);
  }

  EXPECT_THAT(other.ReadOrder(), Optional(1));
  EXPECT_EQ(dispatcher_.statistics().lost_actors, 1);
}

TEST_F(DispatcherTest, CountsAnActorThatGoesWithoutOrdersAsNotLost) {
  {
    TestActor actor(rig_, "a");
    actor.Join();
    actor.stream().CloseWrites();
    EXPECT_THAT(actor.ReadEnd(), StatusIs(absl::StatusCode::kOutOfRange));
  }

  EXPECT_EQ(dispatcher_.statistics().lost_actors, 0);
  EXPECT_EQ(dispatcher_.statistics().actors, 0);
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

TEST_F(DispatcherTest, AdmitsNobodyAfterShutdown) {
  dispatcher_.Shutdown(absl::InfiniteFuture());
  TestActor late(rig_, "late");

  EXPECT_THAT(
      late.Register(MakeRegister("late")),
      StatusIs(absl::StatusCode::kUnavailable, HasSubstr("going away")));
}

// Order ids that were done, by whomever; wakes whoever waits for all of them.
class DoneSet {
 public:
  void Insert(int64_t id) {
    MutexLock lock(mu_);
    ids_.insert(id);
    changed_.NotifyAll();
  }
  bool AwaitSize(size_t size) {
    const auto deadline =
        std::chrono::steady_clock::now() + std::chrono::minutes(1);
    MutexLock lock(mu_);
    while (ids_.size() < size) {
      if (!changed_.WaitUntil(mu_, deadline)) break;
    }
    return ids_.size() >= size;
  }

 private:
  Mutex mu_;
  CondVar changed_;
  std::set<int64_t> ids_ SINEW_GUARDED_BY(mu_);
};

// Runs orders for a while, then breaks off with one in its hands; gives back
// those that this worker does not like. False: the stream ended.
bool LiveAndDie(TestActor& actor, int worker, int lifetime, DoneSet& done) {
  if (!actor.Register(MakeRegister("a")).ok()) return false;
  actor.Want(2);
  for (int i = 0; i < lifetime; ++i) {
    const auto message = actor.stream().Read();
    if (!message.ok() || !message->has_order()) return false;
    const int64_t id = message->order().order_id();
    if (id % 5 == worker) {
      actor.Return({id});
    } else {
      actor.Done(message->order());
      done.Insert(id);
    }
    actor.Want(1);
  }
  return true;
}

TEST(Dispatcher, LosesNoOrderWhileActorsComeAndGo) {
  constexpr int kOrders = 100, kWorkers = 4;
  SystemClock clock;
  DispatcherRig rig(clock);
  DoneSet done;
  std::vector<std::jthread> workers;
  for (int worker = 0; worker < kWorkers; ++worker) {
    workers.emplace_back([&rig, &done, worker] {
      for (int life = 0, alive = 1; alive != 0; ++life) {
        TestActor actor(rig, absl::StrCat(worker, "/", life));
        alive = LiveAndDie(actor, worker, 1 + (worker + life) % 5, done);
      }
    });
  }

  for (int id = 0; id < kOrders; ++id) rig.dispatcher().Add(MakeOrders({id}));

  EXPECT_TRUE(done.AwaitSize(kOrders));
  rig.dispatcher().Shutdown(absl::InfinitePast());
}

}  // namespace
}  // namespace sinew::learner
