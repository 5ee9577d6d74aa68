// The whole actor, physics included, over loopback TCP.
#include <cstdint>
#include <future>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "actor/service/actor.h"
#include "actor/service/actor_metrics.h"
#include "actor/service/rollout_engine.h"
#include "actor/service/testing/fake_learner.h"
#include "actor/testing/rollout_rig.h"
#include "common/digest.h"
#include "common/metrics/registry.h"
#include "common/metrics/testing/lint.h"
#include "common/rpc/testing/socket_folder.h"
#include "common/testing/matchers.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "replay/testing/segments.h"

namespace sinew::actor {
namespace {

using ::sinew::testing::IsOk;
using ::sinew::testing::StatusIs;
using ::testing::AllOf;
using testing::Bytes;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using testing::RolloutRig;

class EndToEndTest : public ::testing::Test {
 protected:
  EndToEndTest()
      : learner_("127.0.0.1:0", rig_.asset_bytes),
        snapshot_sha256_(
            learner_.Publish(SerializeDeterministically(rig_.message))) {}
  ~EndToEndTest() override {
    stop_.request_stop();
    if (running_.valid()) running_.wait();
  }

  void StartActor(int threads) {
    Actor::Options options;
    options.dispatcher_address = learner_.address();
    options.cache_folder = folder_.path() + "/cache";
    options.threads = threads;
    auto actor = Actor::Create(options, engine_, metrics_);
    ASSERT_THAT(actor, IsOk());
    actor_ = *std::move(actor);
    running_ = std::async(std::launch::async,
                          [this] { return actor_->Run(stop_.get_token()); });
  }

  absl::Status StopAndEnd() {
    stop_.request_stop();
    return running_.get();
  }

  v1::Order MakeOrder(int64_t id, int environments, int horizon) {
    v1::Order order = rig_.TrainOrder(environments, horizon);
    order.set_order_id(id);
    order.set_run_id(replay::kRun);
    order.set_assets_sha256(learner_.assets_sha256());
    EXPECT_EQ(order.snapshot_sha256(), snapshot_sha256_);
    return order;
  }

  // Opens the order at replay and gives it out.
  void Add(const v1::Order& order) {
    v1::OpenRequest request;
    request.set_run_id(order.run_id());
    *request.mutable_layout() = rig_.assets->layout();
    v1::OpenRequest::Expected* expected = request.add_expected();
    expected->set_order_id(order.order_id());
    expected->set_snapshot_version(order.snapshot_version());
    expected->set_snapshot_sha256(order.snapshot_sha256());
    expected->set_layout_sha256(order.layout_sha256());
    expected->set_environments(order.states_size());
    expected->set_steps(order.horizon());
    ASSERT_THAT(learner_.replay().Open(request), IsOk());
    learner_.dispatcher().Add(order);
  }

  v1::Segment Take(int64_t id) {
    const auto segments = learner_.replay().Take({id});
    EXPECT_THAT(segments, IsOk());
    return *segments->at(0);
  }

  const rpc::SocketFolder folder_;
  RolloutRig rig_;
  FakeLearner learner_;
  const std::string snapshot_sha256_;
  metrics::Registry registry_{{.role = "actor", .build = ""}};
  ActorMetrics metrics_{registry_};
  RolloutEngine engine_;
  StopSource stop_;
  std::unique_ptr<Actor> actor_;
  std::future<absl::Status> running_;
};

TEST_F(EndToEndTest, SegmentsAreThoseOfTheRolloutFunction) {
  StartActor(/*threads=*/2);
  std::map<int64_t, v1::Order> orders;
  for (int64_t id : {1, 2, 3}) {
    orders[id] = MakeOrder(id, /*environments=*/2, /*horizon=*/20);
    orders[id].set_first_environment(static_cast<int32_t>(2 * id));
    Add(orders[id]);
  }

  // Each goes on where it ended, perhaps on the other thread.
  for (int64_t id : {1, 2, 3}) {
    const v1::Segment segment = Take(id);
    EXPECT_TRUE(Bytes(segment) == Bytes(rig_.Run(orders[id]))) << id;
    v1::Order next = orders[id];
    next.set_order_id(id + 3);
    *next.mutable_states() = segment.end_states();
    orders[id + 3] = next;
    Add(next);
  }
  for (int64_t id : {4, 5, 6}) {
    EXPECT_TRUE(Bytes(Take(id)) == Bytes(rig_.Run(orders[id]))) << id;
  }

  learner_.dispatcher().WaitForDone(6);
  EXPECT_THAT(StopAndEnd(), IsOk());
  const std::string text = registry_.Text();
  EXPECT_THAT(text, HasSubstr("sinew_env_steps_total 240"));
  EXPECT_THAT(text, HasSubstr("sinew_physics_steps_total 960"));
  EXPECT_THAT(text, HasSubstr("sinew_segments_accepted_total 6"));
  EXPECT_THAT(metrics::Lint(text), IsOk());
}

TEST_F(EndToEndTest, ADivergedSimulationIsCountedAndNeverSentAsItIs) {
  StartActor(1);
  v1::Order order = MakeOrder(1, 2, 3);
  *order.mutable_states(1) = rig_.StandingState();
  // time, qpos, then qvel: upwards at a million metres a second.
  order.mutable_states(1)->set_physics(1 + 11 + 2, 1e6);

  Add(order);

  const v1::Segment segment = Take(1);
  EXPECT_EQ(segment.diverged(), 1);
  EXPECT_TRUE(CheckColumnsFinite(segment).ok());
  learner_.dispatcher().WaitForDone(1);
  EXPECT_THAT(
      registry_.Text(),
      AllOf(HasSubstr("sinew_simulations_diverged_total 1"),
            HasSubstr("sinew_episode_ends_total{reason=\"diverged\"} 1"),
            HasSubstr("sinew_segments_refused_total{reason=\"non_finite\"} "
                      "0")));
}

TEST_F(EndToEndTest, AnOrderOfAnotherLayoutIsRefusedInClearText) {
  StartActor(1);
  v1::Order order = MakeOrder(1, 1, 3);
  order.set_layout_sha256("other");

  learner_.dispatcher().Add(order);

  EXPECT_THAT(running_.get(),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr(absl::StrCat(
                           "order 1 field layout_sha256: expected ",
                           rig_.assets->layout_sha256(), ", found other"))));
  EXPECT_THAT(learner_.dispatcher().returned(), ElementsAre(1));
}

TEST_F(EndToEndTest, ASnapshotThatIsNoneIsRefusedByItsDigest) {
  StartActor(1);
  v1::Order order = MakeOrder(1, 1, 3);
  order.set_snapshot_sha256(learner_.Publish("\xff nonsense"));

  learner_.dispatcher().Add(order);

  EXPECT_THAT(
      running_.get(),
      StatusIs(absl::StatusCode::kInvalidArgument,
               HasSubstr(absl::StrCat("snapshot ", order.snapshot_sha256()))));
}

}  // namespace
}  // namespace sinew::actor
