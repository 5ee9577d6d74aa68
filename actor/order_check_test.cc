// Orders that a worker refuses, as order_check.h and environment.h say.

#include "actor/order_check.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <memory>
#include <utility>

#include "actor/prepared_snapshot.h"
#include "actor/rollout.h"
#include "actor/rollout_assets.h"
#include "actor/testing/rollout_rig.h"
#include "common/testing/matchers.h"
#include "sim/world/testing/toy_world.h"

namespace sinew::actor {
namespace {

using ::sinew::testing::IsOk;
using ::sinew::testing::StatusIs;
using ::testing::HasSubstr;
using testing::RolloutRig;

constexpr int kMaxEnvironments = 4;

class RefusalTest : public ::testing::Test {
 protected:
  void ExpectRefused(const v1::Order& order, const char* message) {
    EXPECT_THAT(
        rig_.worker->Run(order, *rig_.snapshot),
        StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr(message)));
  }
  RolloutRig rig_;
};

TEST_F(RefusalTest, OfOrdersForOtherSnapshotsLayoutsAndKinds) {
  v1::Order order = rig_.TrainOrder(1, 5);
  order.set_layout_sha256("abc");
  ExpectRefused(order, "order 7 field layout_sha256: expected ");
  order = rig_.TrainOrder(1, 5);
  order.set_snapshot_version(4);
  ExpectRefused(order, "field snapshot_version: expected 0, found 4");
  order = rig_.TrainOrder(1, 5);
  order.set_snapshot_sha256("");
  ExpectRefused(order, "field snapshot_sha256: expected ");
  order.set_snapshot_sha256(rig_.snapshot->sha256());
  order.set_kind(v1::Order::KIND_UNSPECIFIED);
  ExpectRefused(order, "field kind: expected KIND_TRAIN or KIND_EVALUATE");
}

TEST_F(RefusalTest, OfSizesOutOfRange) {
  v1::Order order = rig_.TrainOrder(1, 0);
  ExpectRefused(order, "field horizon: expected >= 1, found 0");
  order = rig_.TrainOrder(5, 1);
  ExpectRefused(order, "field states: expected 1 to 4 environments, found 5");
  order = rig_.EvaluationOrder({});
  ExpectRefused(order, "field starts: expected 1 to 4, found 0");
}

TEST_F(RefusalTest, OfStatesThatDoNotFit) {
  v1::Order good = rig_.TrainOrder(1, 1);
  *good.mutable_states(0) = rig_.StandingState();
  v1::Order order = good;
  order.mutable_states(0)->mutable_physics()->RemoveLast();
  ExpectRefused(order, "order.states[0].physics: expected ");
  order = good;
  order.mutable_states(0)->set_physics(
      3, std::numeric_limits<double>::quiet_NaN());
  ExpectRefused(order, "order.states[0].physics[3]: expected a finite number");
  order = good;
  order.mutable_states(0)->clear_previous_target();
  ExpectRefused(order, "previous_target: expected 4 numbers, found 0");
  order = good;
  order.mutable_states(0)->set_clip(3);
  ExpectRefused(order, "order.states[0].clip: expected 0 to 2, found 3");
  order = good;
  order.mutable_states(0)->set_step(18);
  order.mutable_states(0)->set_start_frame(1);
  ExpectRefused(order, "order.states[0].step: expected 0 to 17, found 18");
  order = good;
  order.mutable_states(0)->set_episode(-1);
  ExpectRefused(order, "order.states[0].episode: expected >= 0, found -1");
}

TEST_F(RefusalTest, OfStartsOutsideTheirClip) {
  ExpectRefused(rig_.EvaluationOrder({{3, 0, 5}}),
                "starts[0].clip: expected 0 to 2, found 3");
  ExpectRefused(rig_.EvaluationOrder({{1, 19, 1}}),
                "starts[0].start_frame: expected 0 to 18, found 19");
  ExpectRefused(rig_.EvaluationOrder({{0, 0, 5}, {1, 10, 10}}),
                "starts[1].steps: expected 1 to 9, found 10");
}

TEST(OrderCheck, RefusesToTrainWhereAllClipsAreLeftOut) {
  const RolloutRig rig;
  world::testing::ToyWorld toy = world::testing::MakeToyWorld();
  LeaveOut({0, 1, 2}, toy);
  const auto assets = RolloutAssets::FromParts(
      toy.recipe, std::move(toy.character), std::move(toy.library));
  ASSERT_THAT(assets, IsOk());
  const auto snapshot =
      PreparedSnapshot::Create(rig.message, rig.snapshot->sha256(), **assets);
  ASSERT_THAT(snapshot, IsOk());

  EXPECT_THAT(
      CheckOrder(rig.TrainOrder(1, 5), **snapshot, **assets, kMaxEnvironments),
      StatusIs(
          absl::StatusCode::kInvalidArgument,
          HasSubstr("order 7 field kind: expected KIND_EVALUATE, since all "
                    "clips of the library are left out of training, found "
                    "KIND_TRAIN")));
  EXPECT_THAT(CheckOrder(rig.EvaluationOrder({{0, 0, 5}}), **snapshot, **assets,
                         kMaxEnvironments),
              IsOk());
}

TEST(OrderCheck, TakesTrainingWhereAClipIsLeft) {
  const RolloutRig rig;

  EXPECT_THAT(CheckOrder(rig.TrainOrder(1, 5), *rig.snapshot, *rig.assets,
                         kMaxEnvironments),
              IsOk());
}

}  // namespace
}  // namespace sinew::actor
