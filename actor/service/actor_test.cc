// An actor against a learner's services on a socket, without physics.
#include "actor/service/actor.h"

#include <string>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "actor/service/actor_metrics.h"
#include "actor/service/testing/actor_fixture.h"
#include "actor/service/testing/fake_engine.h"
#include "common/digest.h"
#include "common/files.h"
#include "common/metrics/registry.h"
#include "common/metrics/testing/lint.h"
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
using ::testing::IsEmpty;
using ::testing::SizeIs;
using ::testing::UnorderedElementsAre;

class ActorTest : public ActorFixture {};

TEST_F(ActorTest, WorksOverTcpFromAnEmptyFolder) {
  Learner learner("127.0.0.1:0");
  Start(learner);

  for (int64_t id : {1, 2, 3, 4, 5}) learner.Add(id);

  EXPECT_THAT(learner.Take({1, 2, 3, 4, 5}), IsOk());
  learner.dispatcher().WaitForDone(5);
  EXPECT_THAT(learner.dispatcher().done(), UnorderedElementsAre(1, 2, 3, 4, 5));
  EXPECT_THAT(StopAndEnd(), IsOk());
  // The list of assets and the model.
  EXPECT_THAT(*ListDirectory(folder_.path() + "/cache"), SizeIs(2));
}

TEST_F(ActorTest, SaysWhoItIsAndStaysAlive) {
  Learner learner(folder_.Address("l"));
  Start(learner);

  learner.dispatcher().WaitForHeartbeats(3);

  const auto registered = learner.dispatcher().registered();
  ASSERT_THAT(registered, SizeIs(1));
  EXPECT_EQ(registered[0].protocol_version(), 1);
  EXPECT_EQ(registered[0].name(), "actor 1");
  EXPECT_EQ(registered[0].build(), "build");
  EXPECT_EQ(registered[0].threads(), 2);
}

TEST_F(ActorTest, KeepsOneOrderPerThreadInReserve) {
  Learner learner(folder_.Address("l"));
  engine_.Hold();
  Start(learner);

  learner.dispatcher().WaitForWanted(4);
  for (int64_t id : {1, 2, 3, 4}) learner.Add(id);
  learner.dispatcher().WaitForWanted(0);
  engine_.WaitUntilHeld(2);
  engine_.Release();

  learner.dispatcher().WaitForWanted(4);
  EXPECT_THAT(learner.Take({1, 2, 3, 4}), IsOk());
}

TEST_F(ActorTest, FetchesEachSnapshotOnce) {
  Learner learner(folder_.Address("l"));
  Start(learner);

  for (int64_t id : {1, 2, 3, 4}) learner.Add(id, /*iteration=*/id / 3);

  EXPECT_THAT(learner.Take({1, 2, 3, 4}), IsOk());
  EXPECT_EQ(engine_.snapshots_loaded(), 2);
}

TEST_F(ActorTest, GivesBackAnOrderThatCannotWorkAndEndsWithTheError) {
  Learner learner(folder_.Address("l"));
  engine_.Fail(7, absl::InvalidArgumentError(
                      "order field horizon: expected >= 1, found 0"));
  Start(learner);

  learner.Add(7);

  EXPECT_THAT(End(), StatusIs(absl::StatusCode::kInvalidArgument,
                              HasSubstr("order 7: order field horizon")));
  EXPECT_THAT(learner.dispatcher().returned(), ElementsAre(7));
  EXPECT_THAT(learner.dispatcher().reasons()[0], HasSubstr("horizon"));
}

TEST_F(ActorTest, GivesBackAnOrderWhoseSnapshotIsGoneAndGoesOn) {
  Learner learner(folder_.Address("l"));
  Start(learner);
  v1::Order stale = learner.MakeOrder(1);
  stale.set_snapshot_sha256(Sha256Hex("retired"));
  learner.dispatcher().Add(stale);
  learner.dispatcher().WaitForReturned(1);

  learner.Add(2);

  EXPECT_THAT(learner.Take({2}), IsOk());
  EXPECT_THAT(learner.dispatcher().reasons()[0], HasSubstr("no blob"));
}

TEST_F(ActorTest, IsHeldBackByAFullReplay) {
  // Room for one segment at a time, and one in the outbox.
  Learner learner(folder_.Address("l"), replay::TestReplay::SegmentBytes());
  Actor::Options options = Options(learner.address());
  options.outbox_bytes = 1;
  options.threads = 1;
  Start(options);
  auto other = learner.replay().OccupyRoom(9);
  for (int64_t id : {1, 2, 3, 4}) learner.Add(id, /*iteration=*/id);
  // Order 1 is in the outbox, 2 waits to get in, 3 in reserve: no more than
  // one order was finished, so 3 of 4 were given out.
  learner.dispatcher().WaitForGiven(3);
  EXPECT_EQ(metrics_.accepted.Value(), 0);

  other.reset();
  for (int64_t id : {1, 2, 3, 4}) {
    EXPECT_THAT(learner.Take({id}), IsOk());
  }

  learner.dispatcher().WaitForDone(4);
  double blocked = 0;
  for (const auto& done : learner.dispatcher().done_messages()) {
    blocked += done.blocked_seconds();
  }
  EXPECT_GT(blocked, 0);
}

TEST_F(ActorTest, DropsWhatReplayRefusesAndCountsIt) {
  Learner learner(folder_.Address("l"));
  Start(learner);

  learner.dispatcher().Add(learner.MakeOrder(1));  // never opened
  learner.dispatcher().WaitForDone(1);

  EXPECT_THAT(registry_.Text(),
              HasSubstr("sinew_segments_refused_total{reason=\"unexpected\"} "
                        "1"));
}

TEST_F(ActorTest, SaysWhichIssueOfAnOrderIsDone) {
  Learner learner(folder_.Address("l"));
  Start(learner);
  v1::Order order = learner.MakeOrder(1);
  order.set_issue(42);

  learner.dispatcher().Add(order);  // never opened: unexpected
  learner.dispatcher().WaitForDone(1);

  EXPECT_EQ(learner.dispatcher().done_messages()[0].issue(), 42);
}

TEST_F(ActorTest, GivesAnOrderBackWhoseSegmentReplayRefusesForGood) {
  Learner learner(folder_.Address("l"));
  Actor::Options options = Options(learner.address());
  options.threads = 1;
  engine_.Spoil(1);
  learner.Add(1);
  Start(options);

  learner.dispatcher().WaitForReturned(1);

  EXPECT_THAT(learner.dispatcher().returned(), ElementsAre(1));
  EXPECT_THAT(learner.dispatcher().done(), IsEmpty());
  EXPECT_EQ(learner.dispatcher().refused(), 1);
  EXPECT_THAT(learner.dispatcher().reasons()[0],
              HasSubstr("VERDICT_NON_FINITE: "));
}

TEST_F(ActorTest, ReportsItsMetricsByPrometheusRules) {
  Learner learner(folder_.Address("l"));
  Start(learner);
  learner.Add(1, /*iteration=*/1);
  EXPECT_THAT(learner.Take({1}), IsOk());
  learner.dispatcher().WaitForDone(1);

  const std::string text = registry_.Text();

  EXPECT_THAT(text, HasSubstr("sinew_env_steps_total 6"));
  EXPECT_THAT(text, HasSubstr("sinew_physics_steps_total 1"));
  EXPECT_THAT(text, HasSubstr("sinew_build_info{build=\"build\","));
  for (const char* stage : {"simulate", "infer", "observe", "encode", "fetch",
                            "idle", "blocked", "send"}) {
    EXPECT_THAT(text, HasSubstr(absl::StrCat(
                          "sinew_stage_seconds_total{stage=\"", stage, "\"}")));
  }
  for (const char* reason :
       {"terminated", "time_limit", "clip_end", "diverged"}) {
    EXPECT_THAT(text,
                HasSubstr(absl::StrCat("sinew_episode_ends_total{reason=\"",
                                       reason, "\"}")));
  }
  EXPECT_THAT(text, HasSubstr("sinew_simulations_diverged_total 0"));
  EXPECT_THAT(text, HasSubstr("sinew_queue_limit_bytes 67108864"));
  EXPECT_THAT(text, HasSubstr("sinew_applied_policy_version 1"));
  EXPECT_THAT(text, HasSubstr("sinew_segments_accepted_total 1"));
  EXPECT_THAT(text, HasSubstr("sinew_publish_to_apply_seconds_count 1"));
  EXPECT_THAT(metrics::Lint(text), IsOk());
}

TEST(Actor, RefusesImpossibleOptions) {
  metrics::Registry registry({.role = "actor", .build = ""});
  ActorMetrics metrics(registry);
  FakeEngine engine;
  Actor::Options options;
  options.dispatcher_address = "unix:/tmp/x";
  options.threads = 0;

  EXPECT_THAT(Actor::Create(options, engine, metrics),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("threads: expected >= 1, found 0")));
  options.threads = 1;
  options.dispatcher_address = "nonsense";
  EXPECT_THAT(
      Actor::Create(options, engine, metrics),
      StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr("nonsense")));
}

}  // namespace
}  // namespace sinew::actor
