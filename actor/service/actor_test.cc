// An actor against a learner's services on a socket, without physics.
#include "actor/service/actor.h"

#include <future>
#include <memory>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "absl/time/time.h"
#include "actor/service/actor_metrics.h"
#include "actor/service/testing/fake_dispatcher.h"
#include "actor/service/testing/fake_engine.h"
#include "common/blobs/blob_ring.h"
#include "common/blobs/blobs_service.h"
#include "common/digest.h"
#include "common/files.h"
#include "common/metrics/registry.h"
#include "common/metrics/testing/lint.h"
#include "common/rpc/server.h"
#include "common/rpc/testing/socket_folder.h"
#include "common/testing/matchers.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "replay/replay_metrics.h"
#include "replay/service/replay_service.h"
#include "replay/table.h"
#include "replay/testing/segments.h"
#include "replay/validate.h"

namespace sinew::actor {
namespace {

using ::sinew::testing::IsOk;
using ::sinew::testing::StatusIs;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::SizeIs;
using ::testing::UnorderedElementsAre;

constexpr auto kNever = [] { return false; };

std::string PutAssets(BlobRing& blobs) {
  v1::TaskAssets assets;
  v1::Asset* model = assets.add_assets();
  model->set_role("model");
  model->set_sha256(*blobs.Put("the model"));
  return *blobs.Put(SerializeDeterministically(assets));
}

// Dispatcher, blobs and replay in one server.
class Learner {
 public:
  explicit Learner(const std::string& address,
                   int64_t replay_bytes = int64_t{1} << 30)
      : blobs_(int64_t{1} << 30),
        assets_sha256_(PutAssets(blobs_)),
        table_({.limit_bytes = replay_bytes}, replay_metrics_),
        dispatcher_(MakeWelcome()) {
    EXPECT_THAT(blobs_.Put("snapshot 0"), IsOk());
    EXPECT_THAT(blobs_.Put("snapshot 1"), IsOk());
    auto server = rpc::Server::Start(
        {.address = address}, {&dispatcher_, &blobs_service_, &replay_service_});
    EXPECT_THAT(server, IsOk());
    server_ = *std::move(server);
    EXPECT_THAT(table_.Open(replay::MakeOpen({}, 0, /*reset=*/true)), IsOk());
  }
  ~Learner() { Shutdown(); }

  void Shutdown() {
    table_.Close();
    server_->Shutdown(absl::ZeroDuration());
  }

  v1::Order MakeOrder(int64_t id, int64_t iteration = 0) {
    const v1::OpenRequest::Expected expected =
        replay::MakeExpected(id, iteration);
    v1::Order order;
    order.set_run_id(replay::kRun);
    order.set_order_id(id);
    order.set_kind(v1::Order::KIND_TRAIN);
    order.set_iteration(iteration);
    order.set_snapshot_version(expected.snapshot_version());
    order.set_snapshot_sha256(expected.snapshot_sha256());
    order.set_assets_sha256(assets_sha256_);
    order.set_layout_sha256(expected.layout_sha256());
    order.set_horizon(replay::kSteps);
    for (int i = 0; i < replay::kEnvironments; ++i) order.add_states();
    return order;
  }

  // Opens an order at replay and gives it out.
  void Add(int64_t id, int64_t iteration = 0) {
    EXPECT_THAT(table_.Open(replay::MakeOpen({id}, iteration)), IsOk());
    dispatcher_.Add(MakeOrder(id, iteration));
  }

  absl::Status Take(const std::vector<int64_t>& ids) {
    const auto segments = table_.Collect(replay::kRun, ids,
                                         absl::InfiniteFuture(), kNever);
    table_.Remove(replay::kRun, ids);
    return segments.status();
  }

  FakeDispatcher& dispatcher() { return dispatcher_; }
  replay::Table& table() { return table_; }
  const std::string& address() const { return server_->address(); }

 private:
  v1::DispatcherMessage::Welcome MakeWelcome() {
    v1::DispatcherMessage::Welcome welcome;
    welcome.set_run_id(replay::kRun);
    welcome.set_heartbeat_seconds(0.01);
    welcome.set_assets_sha256(assets_sha256_);
    return welcome;
  }

  BlobRing blobs_;
  const std::string assets_sha256_;
  metrics::Registry registry_{{.role = "learner", .build = ""}};
  replay::ReplayMetrics replay_metrics_{registry_};
  replay::Table table_;
  FakeDispatcher dispatcher_;
  BlobsService blobs_service_{blobs_};
  replay::ReplayService replay_service_{table_};
  std::unique_ptr<rpc::Server> server_;
};

class ActorTest : public ::testing::Test {
 protected:
  ~ActorTest() override {
    engine_.Release();
    if (running_.valid()) {
      stop_.request_stop();
      running_.wait();
    }
  }

  Actor::Options Options(const std::string& address) {
    Actor::Options options;
    options.dispatcher_address = address;
    options.cache_folder = folder_.path() + "/cache";
    options.threads = 2;
    options.name = "actor 1";
    options.build = "build";
    options.drain_timeout = absl::Seconds(30);
    options.backoff = {.initial = absl::Milliseconds(1),
                       .longest = absl::Milliseconds(20)};
    return options;
  }

  void Start(const Actor::Options& options) {
    auto actor = Actor::Create(options, engine_, metrics_);
    ASSERT_THAT(actor, IsOk());
    actor_ = *std::move(actor);
    running_ = std::async(std::launch::async, [this] {
      return actor_->Run(stop_.get_token());
    });
  }
  void Start(const Learner& learner) { Start(Options(learner.address())); }

  absl::Status End() { return running_.get(); }
  absl::Status StopAndEnd() {
    stop_.request_stop();
    return End();
  }

  const rpc::SocketFolder folder_;
  metrics::Registry registry_{{.role = "actor", .build = "build"}};
  ActorMetrics metrics_{registry_};
  FakeEngine engine_;
  StopSource stop_;
  std::unique_ptr<Actor> actor_;
  std::future<absl::Status> running_;
};

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

TEST_F(ActorTest, FinishesWhatRunsAndGivesBackTheRestWhenStopped) {
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

TEST_F(ActorTest, GivesBackWhatItCannotFinishInTime) {
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

TEST_F(ActorTest, GivesBackSegmentsThatReplayDoesNotTakeInTime) {
  // Room for one segment, which is taken by another writer.
  Learner learner(folder_.Address("l"),
                  replay::MaxSegmentBytes(replay::MakeExpectation(0)));
  EXPECT_THAT(learner.table().Open(replay::MakeOpen({9}, 0)), IsOk());
  const auto other = learner.table().Admit(
      replay::kRun, 9, replay::MaxSegmentBytes(replay::MakeExpectation(0)),
      absl::InfiniteFuture(), kNever);
  ASSERT_THAT(other, IsOk());
  Actor::Options options = Options(learner.address());
  options.drain_timeout = absl::Milliseconds(10);
  Start(options);
  learner.Add(1, /*iteration=*/1);
  learner.dispatcher().WaitForWanted(4);

  EXPECT_THAT(StopAndEnd(), IsOk());

  learner.dispatcher().WaitForReturned(1);
  EXPECT_THAT(learner.dispatcher().returned(), ElementsAre(1));
}

TEST_F(ActorTest, FinishesEverythingWhenTheLearnerDrains) {
  Learner learner(folder_.Address("l"));
  engine_.Hold();
  Start(learner);
  for (int64_t id : {1, 2, 3, 4}) learner.Add(id);
  learner.dispatcher().WaitForWanted(0);

  learner.dispatcher().Drain();
  engine_.Release();

  EXPECT_THAT(End(), IsOk());
  EXPECT_THAT(learner.dispatcher().done(), UnorderedElementsAre(1, 2, 3, 4));
  EXPECT_THAT(learner.dispatcher().returned(), SizeIs(0));
}

TEST_F(ActorTest, ComesBackToALearnerThatWasRestarted) {
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

TEST_F(ActorTest, WaitsForALearnerThatIsNotUpYet) {
  Start(Options(folder_.Address("l")));

  Learner learner(folder_.Address("l"));
  learner.Add(1);

  EXPECT_THAT(learner.Take({1}), IsOk());
}

TEST_F(ActorTest, EndsWhenItIsRefused) {
  Learner learner(folder_.Address("l"));
  learner.dispatcher().Refuse(
      absl::FailedPreconditionError("build: expected a, found build"));
  Start(learner);

  EXPECT_THAT(End(), StatusIs(absl::StatusCode::kFailedPrecondition,
                              HasSubstr("build: expected a, found build")));
}

TEST_F(ActorTest, StopsWhileNobodyAnswers) {
  Start(Options(folder_.Address("nobody")));

  EXPECT_THAT(StopAndEnd(), IsOk());
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
  const int64_t most = replay::MaxSegmentBytes(replay::MakeExpectation(0));
  Learner learner(folder_.Address("l"), most);
  Actor::Options options = Options(learner.address());
  options.outbox_bytes = 1;
  Start(options);
  EXPECT_THAT(learner.table().Open(replay::MakeOpen({9}, 0)), IsOk());
  auto other = learner.table().Admit(replay::kRun, 9, most,
                                     absl::InfiniteFuture(), kNever);
  ASSERT_THAT(other, IsOk());
  for (int64_t id : {1, 2, 3, 4, 5, 6}) learner.Add(id, /*iteration=*/id);
  // Order 1 is in the outbox, 2 and 3 wait to get in, 4 and 5 in reserve: no
  // more than one order was finished, so 5 of 6 were given out.
  learner.dispatcher().WaitForWanted(0);
  EXPECT_EQ(metrics_.accepted.Value(), 0);

  other->room.reset();
  for (int64_t id : {1, 2, 3, 4, 5, 6}) {
    EXPECT_THAT(learner.Take({id}), IsOk());
  }

  learner.dispatcher().WaitForDone(6);
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

TEST_F(ActorTest, ReportsItsMetricsByPrometheusRules) {
  Learner learner(folder_.Address("l"));
  Start(learner);
  learner.Add(1, /*iteration=*/1);
  EXPECT_THAT(learner.Take({1}), IsOk());
  learner.dispatcher().WaitForDone(1);

  const std::string text = registry_.Text();

  EXPECT_THAT(text, HasSubstr("sinew_env_steps_total 6"));
  EXPECT_THAT(text, HasSubstr("sinew_physics_steps_total 1"));
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
  EXPECT_THAT(Actor::Create(options, engine, metrics),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("nonsense")));
}

}  // namespace
}  // namespace sinew::actor
