#include "learner/experience/service_experience.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/time/clock.h"
#include "common/digest.h"
#include "common/logging.h"
#include "common/testing/matchers.h"
#include "common/testing/simulated_clock.h"
#include "learner/dispatcher/testing/dispatcher_rig.h"
#include "learner/experience/testing/fake_replay.h"

namespace sinew::learner {
namespace {

using ::sinew::testing::IsOk;
using ::sinew::testing::SimulatedClock;
using ::sinew::testing::StatusIs;
using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::SizeIs;

v1::Order MakeOrder(int64_t id) {
  v1::Order order;
  order.set_run_id("run");
  order.set_order_id(id);
  order.set_kind(v1::Order::KIND_TRAIN);
  order.set_iteration(4);
  order.set_snapshot_version(3);
  order.set_snapshot_sha256("abc");
  order.set_layout_sha256("def");
  order.set_horizon(16);
  order.add_states();
  order.add_states();
  return order;
}

std::vector<int64_t> Ids(const std::vector<v1::Segment>& segments) {
  std::vector<int64_t> ids;
  for (const v1::Segment& segment : segments) ids.push_back(segment.order_id());
  return ids;
}

class ServiceExperienceTest : public ::testing::Test {
 protected:
  ServiceExperienceTest() {
    options_.run_id = "run";
    options_.layout.add_columns()->set_name("reward");
    options_.limits.set_joints(5);
    options_.address = "host:7000";
    options_.step = absl::Milliseconds(2);
    options_.backoff = {.initial = options_.step, .longest = options_.step};
    options_.stop = stop_.get_token();
    Logger::Options log;
    auto logger = Logger::Create(log, clock_);
    EXPECT_THAT(logger, IsOk());
    (*logger)->SetConsole(
        [this](absl::string_view line) { absl::StrAppend(&log_, line, "\n"); });
    SetProgramLogger(*std::move(logger));
  }
  ~ServiceExperienceTest() override {
    rig_.dispatcher().Shutdown(absl::Now());
    if (actor_.joinable()) actor_.join();
    SetProgramLogger(nullptr);
  }

  void ReplayIsAwayForThreeSteps() {
    replay_.SetAway(true);
    options_.check = [this, steps = 0]() mutable {
      if (++steps == 3) replay_.SetAway(false);
      return absl::OkStatus();
    };
  }

  ServiceExperience& experience() {
    if (experience_ == nullptr) {
      experience_ = std::make_unique<ServiceExperience>(
          options_, rig_.dispatcher(), replay_, ring_, clock_);
    }
    return *experience_;
  }

  // An actor that answers every order with a segment of that id.
  void StartActor() {
    actor_ = std::thread([this] {
      TestActor actor(rig_, "fake");
      actor.Join();
      actor.Want(100);
      for (auto id = actor.ReadOrder(); id; id = actor.ReadOrder()) {
        v1::Segment segment;
        segment.set_order_id(*id);
        EXPECT_THAT(replay_.Put("run", *id, segment.SerializeAsString(),
                                absl::Seconds(10)),
                    IsOk());
        actor.Done(*id);
      }
    });
  }

  SimulatedClock clock_;
  StopSource stop_;
  ServiceExperience::Options options_;
  DispatcherRig rig_{clock_};
  FakeReplay replay_;
  BlobRing ring_{3};
  std::string log_;
  std::unique_ptr<ServiceExperience> experience_;
  std::thread actor_;
};

TEST_F(ServiceExperienceTest, GivesSegmentsInTheOrderOfTheAsking) {
  StartActor();
  ASSERT_THAT(experience().Begin({MakeOrder(1), MakeOrder(2), MakeOrder(3)}),
              IsOk());

  const auto segments = experience().Take({3, 1, 2});

  ASSERT_THAT(segments, IsOk());
  EXPECT_THAT(Ids(*segments), ElementsAre(3, 1, 2));
}

TEST_F(ServiceExperienceTest, TellsReplayWhatAnOrderMustBring) {
  ASSERT_THAT(experience().Begin({MakeOrder(7)}), IsOk());

  const v1::OpenRequest request = replay_.requests().at(0);
  EXPECT_TRUE(request.reset());
  EXPECT_EQ(request.run_id(), "run");
  EXPECT_EQ(request.layout().columns(0).name(), "reward");
  EXPECT_EQ(request.limits().joints(), 5);
  ASSERT_EQ(request.expected_size(), 1);
  const auto& expected = request.expected(0);
  EXPECT_EQ(expected.order_id(), 7);
  EXPECT_EQ(expected.iteration(), 4);
  EXPECT_EQ(expected.snapshot_version(), 3);
  EXPECT_EQ(expected.snapshot_sha256(), "abc");
  EXPECT_EQ(expected.layout_sha256(), "def");
  EXPECT_EQ(expected.environments(), 2);
  EXPECT_EQ(expected.steps(), 16);
}

TEST_F(ServiceExperienceTest, ResetsReplayOnlyAtTheStart) {
  ASSERT_THAT(experience().Begin({MakeOrder(1)}), IsOk());
  ASSERT_THAT(experience().Begin({MakeOrder(2)}), IsOk());

  EXPECT_FALSE(replay_.requests().at(1).reset());
}

TEST_F(ServiceExperienceTest, ForgetsOrdersThatWereTaken) {
  StartActor();
  ASSERT_THAT(experience().Begin({MakeOrder(1), MakeOrder(2)}), IsOk());

  ASSERT_THAT(experience().Take({1, 2}), IsOk());

  EXPECT_EQ(rig_.dispatcher().statistics().orders_waiting, 0);
  EXPECT_EQ(rig_.dispatcher().statistics().orders_leased, 0);
}

TEST_F(ServiceExperienceTest, SaysWhereActorsAreExpectedWhileThereAreNone) {
  options_.check = [this, steps = 0]() mutable {
    clock_.Advance(absl::Seconds(60));
    if (++steps == 3) stop_.request_stop();
    return absl::OkStatus();
  };
  ASSERT_THAT(experience().Begin({MakeOrder(1)}), IsOk());

  EXPECT_THAT(experience().Take({1}), StatusIs(absl::StatusCode::kCancelled));

  EXPECT_THAT(log_, HasSubstr("no actors"));
  EXPECT_THAT(log_, HasSubstr("address=host:7000"));
}

TEST_F(ServiceExperienceTest, CanBeAskedAgainAfterItWasStopped) {
  StopSource stop;
  options_.stop = stop.get_token();
  options_.check = [&stop] {
    stop.request_stop();
    return absl::OkStatus();
  };
  ASSERT_THAT(experience().Begin({MakeOrder(1)}), IsOk());
  ASSERT_THAT(experience().Take({1}), StatusIs(absl::StatusCode::kCancelled));

  StartActor();
  // The segment comes although nobody waits.
  while (true) {
    const auto status = replay_.GetStatus({});
    ASSERT_THAT(status, IsOk());
    if (status->accepted() == 1) break;
    std::this_thread::yield();
  }

  EXPECT_THAT(experience().Take({1}), IsOk());
}

TEST_F(ServiceExperienceTest, EndsWithWhatTheCheckFailsWith) {
  options_.check = [] { return absl::UnavailableError("actor 0 is broken"); };
  ASSERT_THAT(experience().Begin({MakeOrder(1)}), IsOk());

  EXPECT_THAT(experience().Take({1}),
              StatusIs(absl::StatusCode::kUnavailable, "actor 0 is broken"));
}

TEST_F(ServiceExperienceTest, GivesUpOnActorsThatSendNothing) {
  TestActor idle(rig_, "idle");
  idle.Join();
  options_.patience = absl::Minutes(5);
  options_.check = [&] {
    idle.Heartbeat();
    idle.Sync();
    clock_.Advance(absl::Seconds(9));
    return absl::OkStatus();
  };
  ASSERT_THAT(experience().Begin({MakeOrder(1)}), IsOk());

  EXPECT_THAT(experience().Take({1}),
              StatusIs(absl::StatusCode::kDeadlineExceeded,
                       HasSubstr("no segment in 5m from 1 actors: order 1")));
}

TEST_F(ServiceExperienceTest, FailsSoonWhenReplayKeepsRefusingASegment) {
  TestActor actor(rig_, "spoilt");
  actor.Join();
  ASSERT_THAT(experience().Begin({MakeOrder(1)}), IsOk());
  for (int i = 0; i < 3; ++i) {
    actor.Want(1);
    ASSERT_EQ(actor.ReadOrder(), 1);
    actor.Refuse(1, "VERDICT_NON_FINITE: column reward");
  }
  actor.Sync();

  EXPECT_THAT(experience().Take({1}),
              StatusIs(absl::StatusCode::kFailedPrecondition,
                       HasSubstr("VERDICT_NON_FINITE: column reward")));
}

TEST_F(ServiceExperienceTest, BeginsAnewWithAReplayThatWasStartedAgain) {
  ASSERT_THAT(experience().Begin({MakeOrder(1)}), IsOk());
  replay_.Restart();

  ASSERT_THAT(experience().Begin({MakeOrder(2)}), IsOk());

  EXPECT_TRUE(replay_.requests().back().reset());
  EXPECT_EQ(replay_.requests().back().expected_size(), 2);
}

TEST_F(ServiceExperienceTest, HandsOrdersOutAgainIfReplayHasForgottenThem) {
  ASSERT_THAT(experience().Begin({MakeOrder(1), MakeOrder(2)}), IsOk());
  replay_.Forget();
  StartActor();

  const auto segments = experience().Take({1, 2});

  ASSERT_THAT(segments, IsOk());
  EXPECT_THAT(Ids(*segments), ElementsAre(1, 2));
  EXPECT_TRUE(replay_.requests().back().reset());
}

TEST_F(ServiceExperienceTest, HandsOrdersOutAgainWhoseSegmentsWentElsewhere) {
  replay_.PutElsewhere(2);
  options_.check = [steps = 0]() mutable {
    return ++steps < 10'000 ? absl::OkStatus() : absl::InternalError("hangs");
  };
  ASSERT_THAT(experience().Begin({MakeOrder(1), MakeOrder(2), MakeOrder(3)}),
              IsOk());
  StartActor();

  const auto segments = experience().Take({1, 2, 3});

  ASSERT_THAT(segments, IsOk());
  EXPECT_THAT(Ids(*segments), ElementsAre(1, 2, 3));
  EXPECT_THAT(log_, HasSubstr("replay misses segments that actors call done"));
  // What came is not asked for again.
  EXPECT_THAT(replay_.requests(), SizeIs(1));
}

TEST_F(ServiceExperienceTest, FailsWhenActorsKeepSendingToAnotherReplay) {
  replay_.PutElsewhere(1'000'000);
  ASSERT_THAT(experience().Begin({MakeOrder(7)}), IsOk());
  StartActor();

  EXPECT_THAT(experience().Take({7}),
              StatusIs(absl::StatusCode::kFailedPrecondition,
                       AllOf(HasSubstr("order 7"),
                             HasSubstr("send to another replay?"))));
}

TEST_F(ServiceExperienceTest, WaitsForAReplayThatIsAway) {
  ReplayIsAwayForThreeSteps();
  StartActor();
  ASSERT_THAT(experience().Begin({MakeOrder(1)}), IsOk());

  EXPECT_THAT(experience().Take({1}), IsOk());
}

TEST_F(ServiceExperienceTest, StopsAtOnceWhileItWaitsForAReplayThatIsAway) {
  replay_.Hang();
  const std::jthread stopper([this] {
    replay_.AwaitCaller();
    stop_.request_stop();
  });

  EXPECT_THAT(experience().Begin({MakeOrder(1)}), IsOk());

  EXPECT_THAT(experience().Take({1}), StatusIs(absl::StatusCode::kCancelled));
  EXPECT_THAT(log_, Not(HasSubstr("replay is away")));
}

TEST_F(ServiceExperienceTest, LooksForAReplayThatIsAwayMoreOftenThanItSteps) {
  options_.step = absl::Hours(1);
  options_.backoff = {.initial = absl::Milliseconds(1),
                      .longest = absl::Milliseconds(2)};
  ReplayIsAwayForThreeSteps();
  StartActor();
  ASSERT_THAT(experience().Begin({MakeOrder(1)}), IsOk());

  EXPECT_THAT(experience().Take({1}), IsOk());
}

TEST_F(ServiceExperienceTest, TellsReplayThatTheRunEndsUnlessItWasStopped) {
  ASSERT_THAT(experience().Begin({MakeOrder(1)}), IsOk());
  experience().End();
  EXPECT_TRUE(replay_.requests().back().ends());

  stop_.request_stop();
  experience().End();
  EXPECT_THAT(replay_.requests(), SizeIs(2));
}

TEST_F(ServiceExperienceTest, PublishesBytesUnderTheirDigest) {
  PublishedSnapshot snapshot;
  snapshot.bytes = "weights";
  snapshot.sha256 = Sha256Hex(snapshot.bytes);
  ASSERT_THAT(experience().Publish(snapshot), IsOk());
  const auto blob = ring_.GetBlob(snapshot.sha256);
  ASSERT_THAT(blob, IsOk());
  EXPECT_EQ(**blob, "weights");

  snapshot.sha256 = Sha256Hex("other");
  EXPECT_THAT(experience().Publish(snapshot),
              StatusIs(absl::StatusCode::kInternal));
}

}  // namespace
}  // namespace sinew::learner
