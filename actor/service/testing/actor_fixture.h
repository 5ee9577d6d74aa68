#ifndef SINEW_ACTOR_SERVICE_TESTING_ACTOR_FIXTURE_H_
#define SINEW_ACTOR_SERVICE_TESTING_ACTOR_FIXTURE_H_

#include <cstdint>
#include <future>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "absl/time/time.h"
#include "actor/service/actor.h"
#include "actor/service/actor_metrics.h"
#include "actor/service/testing/fake_engine.h"
#include "actor/service/testing/fake_learner.h"
#include "common/metrics/registry.h"
#include "common/rpc/testing/socket_folder.h"
#include "common/stop.h"
#include "common/testing/matchers.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "replay/testing/segments.h"

namespace sinew::actor {

// A FakeLearner whose orders are those of replay/testing/segments.h.
class Learner : public FakeLearner {
 public:
  explicit Learner(const std::string& address,
                   int64_t replay_bytes = int64_t{1} << 30)
      : FakeLearner(address, {{"model", "the model"}}, replay_bytes) {
    for (int i = 0; i < 8; ++i) Publish(absl::StrCat("snapshot ", i));
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
    order.set_assets_sha256(assets_sha256());
    order.set_layout_sha256(expected.layout_sha256());
    order.set_horizon(replay::kSteps);
    for (int i = 0; i < replay::kEnvironments; ++i) order.add_states();
    return order;
  }

  // Opens an order at replay and gives it out.
  void Add(int64_t id, int64_t iteration = 0) {
    EXPECT_THAT(replay().Open(replay::MakeOpen({id}, iteration)),
                sinew::testing::IsOk());
    dispatcher().Add(MakeOrder(id, iteration));
  }

  absl::Status Take(const std::vector<int64_t>& ids) {
    return replay().Take(ids).status();
  }
};

// An actor with a FakeEngine, run on a thread of its own.
class ActorFixture : public ::testing::Test {
 protected:
  ~ActorFixture() override {
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
    ASSERT_THAT(actor, sinew::testing::IsOk());
    actor_ = *std::move(actor);
    running_ = std::async(std::launch::async,
                          [this] { return actor_->Run(stop_.get_token()); });
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

}  // namespace sinew::actor

#endif  // SINEW_ACTOR_SERVICE_TESTING_ACTOR_FIXTURE_H_
