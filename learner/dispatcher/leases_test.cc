// What becomes of orders whose actors are late, leave or fail.
#include <chrono>
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
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "learner/dispatcher/testing/dispatcher_fixture.h"
#include "learner/dispatcher/testing/dispatcher_rig.h"

namespace sinew::learner {
namespace {

using ::sinew::testing::StatusIs;
using ::testing::HasSubstr;
using ::testing::Optional;

class LeasesTest : public DispatcherFixture {};

TEST_F(LeasesTest, HandsTheOrdersOfASilentActorToAnother) {
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

TEST_F(LeasesTest, KeepsTheLeasesOfAnActorWhoseHeartBeats) {
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

TEST_F(LeasesTest, IssuesALateOrderAgainWhileTheFirstActorLives) {
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

TEST_F(LeasesTest, HandsAReturnedOrderToAnother) {
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

TEST_F(LeasesTest, GivesARefusedOrderOutTwiceMoreAndThenFails) {
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

TEST_F(LeasesTest, IgnoresTheRefusalOfAnOrderThatHasASegment) {
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

TEST_F(LeasesTest, ALateDoneDoesNotFinishAnOrderThatWasAddedAgain) {
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

TEST_F(LeasesTest, AnActorsAnswerToAnEarlierLearnerFinishesNothing) {
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

TEST_F(LeasesTest, HandsTheOrdersOfABrokenStreamToAnother) {
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

TEST_F(LeasesTest, CountsAnActorThatGoesWithoutOrdersAsNotLost) {
  {
    TestActor actor(rig_, "a");
    actor.Join();
    actor.stream().CloseWrites();
    EXPECT_THAT(actor.ReadEnd(), StatusIs(absl::StatusCode::kOutOfRange));
  }

  EXPECT_EQ(dispatcher_.statistics().lost_actors, 0);
  EXPECT_EQ(dispatcher_.statistics().actors, 0);
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

TEST(Leases, LosesNoOrderWhileActorsComeAndGo) {
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
