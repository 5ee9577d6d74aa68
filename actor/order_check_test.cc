#include "actor/order_check.h"

#include <memory>
#include <utility>

#include "absl/status/status.h"
#include "actor/prepared_snapshot.h"
#include "actor/rollout_assets.h"
#include "actor/testing/rollout_rig.h"
#include "common/testing/matchers.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "sim/world/testing/toy_world.h"

namespace sinew::actor {
namespace {

using ::sinew::actor::testing::RolloutRig;
using ::sinew::testing::IsOk;
using ::sinew::testing::StatusIs;
using ::testing::HasSubstr;

constexpr int kMaxEnvironments = 4;

// What else is refused: rollout_test.cc.
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
