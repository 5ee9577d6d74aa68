// Rollouts of a recipe with fallen and far starts.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>
#include <string>

#include "actor/rollout.h"
#include "actor/testing/rollout_rig.h"
#include "common/config/recipe.h"
#include "common/digest.h"
#include "common/segment/segment_layout.h"
#include "common/testing/matchers.h"
#include "sim/world/testing/toy_world.h"

namespace sinew::actor {
namespace {

using ::sinew::testing::StatusIs;
using testing::Bytes;
using testing::Column;
using ::testing::HasSubstr;
using testing::RolloutRig;

// Most episodes start off the reference, and recover for 6 steps.
v1::Recipe RecoveryRecipe() {
  v1::Recipe recipe = world::testing::ToyRecipe();
  v1::Recovery* recovery = recipe.mutable_task()->mutable_recovery();
  recovery->set_fallen_share(0.4);
  recovery->set_far_share(0.4);
  recovery->set_steps(6);
  recovery->set_fallen_states(3);
  return WithDefaults(recipe);
}

TEST(RecoveryRollout, MixesStartsAndEndsNoEpisodeThatRecovers) {
  RolloutRig rig(RecoveryRecipe());

  const v1::Segment segment = rig.Run(rig.TrainOrder(4, 80));

  ASSERT_GT(segment.episodes_size(), 10);
  std::set<int> kinds;
  for (const v1::EpisodeEnd& end : segment.episodes()) {
    kinds.insert(end.start_kind());
    if (end.reason() == v1::EpisodeEnd::REASON_DIVERGED) continue;
    if (end.start_kind() != v1::START_KIND_REFERENCE) {
      EXPECT_GT(end.steps(), 6);
    }
  }
  EXPECT_EQ(kinds.size(), 3);
  EXPECT_TRUE(CheckColumnsFinite(segment).ok());
}

TEST(RecoveryRollout, CutInTwoHalvesIsTheSameRollout) {
  RolloutRig rig(RecoveryRecipe());
  // Cut where environments are in the middle of their recovery.
  const v1::Segment whole = rig.Run(rig.TrainOrder(3, 44));
  v1::Order order = rig.TrainOrder(3, 3);
  const v1::Segment first = rig.Run(order);
  *order.mutable_states() = first.end_states();
  order.set_horizon(41);
  rig.NewWorker();
  const v1::Segment second = rig.Run(order);

  int recovering = 0;
  for (const v1::EnvironmentState& state : first.end_states()) {
    if (state.recovery_steps_left() > 0) ++recovering;
  }
  ASSERT_GT(recovering, 0);
  rig.ExpectTogether(whole, first, second);
}

TEST(RecoveryRollout, ClockStandsWhileAnEnvironmentRecovers) {
  RolloutRig rig(RecoveryRecipe());
  v1::Order order = rig.TrainOrder(4, 5);
  const v1::Segment segment = rig.Run(order);

  const auto frames = Column<int32_t>(segment, "frame");
  int standing = 0;
  for (int e = 0; e < 4; ++e) {
    const v1::EnvironmentState& state = segment.end_states(e);
    if (state.step() != 5 || state.frozen_steps() != 5) continue;
    ++standing;
    for (int t = 0; t < 5; ++t) EXPECT_EQ(frames[t * 4 + e], frames[e]);
    EXPECT_EQ(state.recovery_steps_left(), 1);
  }
  EXPECT_GT(standing, 0);
}

TEST(RecoveryRollout, NeedsTheAssetItStartsFrom) {
  RolloutRig rig(RecoveryRecipe());
  const auto& bytes = rig.asset_bytes;
  const auto assets = RolloutAssets::Create(
      bytes.at("character"), bytes.at("model"), bytes.at("library"),
      bytes.at("frames"), bytes.at("recipe"));
  ASSERT_TRUE(assets.ok()) << assets.status();
  const auto worker = RolloutWorker::Create(*assets, 4);
  ASSERT_TRUE(worker.ok()) << worker.status();

  EXPECT_THAT((*worker)->Run(rig.TrainOrder(1, 4), *rig.snapshot).status(),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("assets of role \"fallen\"")));
}

v1::Recipe GetUpRecipe() {
  v1::Recipe recipe = RecoveryRecipe();
  v1::Recovery* recovery = recipe.mutable_task()->mutable_recovery();
  recovery->clear_fallen_share();
  recovery->set_get_up_share(0.6);
  return WithDefaults(recipe);
}

TEST(RecoveryRollout, PutsFallenBodiesOnGetUps) {
  RolloutRig rig(GetUpRecipe(), world::testing::ToyClips::kWithGetUp);

  const v1::Segment segment = rig.RunWholeAndInHalves(4, 80);

  int get_ups = 0;
  for (const v1::EpisodeEnd& end : segment.episodes()) {
    if (end.start_kind() != v1::START_KIND_GET_UP) continue;
    ++get_ups;
    EXPECT_EQ(end.clip(), 1);
    EXPECT_LT(end.start_frame(), 7);
    if (end.reason() == v1::EpisodeEnd::REASON_DIVERGED) continue;
    EXPECT_GT(end.steps(), 20);
  }
  EXPECT_GT(get_ups, 2);
  // Where a get-up is over, the next episode begins with the body as it is, in
  // the one clip that stays up.
  int onward = 0;
  for (const v1::EpisodeEnd& before : segment.episodes()) {
    for (const v1::EpisodeEnd& after : segment.episodes()) {
      if (after.environment() != before.environment() ||
          after.episode() != before.episode() + 1) {
        continue;
      }
      const bool goes_on = before.start_kind() == v1::START_KIND_GET_UP &&
                           before.reason() == v1::EpisodeEnd::REASON_CLIP_END &&
                           after.start_kind() == v1::START_KIND_CARRIED;
      EXPECT_EQ(goes_on, after.start_kind() == v1::START_KIND_CARRIED);
      if (!goes_on) continue;
      ++onward;
      EXPECT_EQ(after.clip(), 0);
    }
  }
  EXPECT_GT(onward, 0);
  EXPECT_TRUE(CheckColumnsFinite(segment).ok());
}

TEST(RecoveryRollout, NeedsAGetUpToPutThemOn) {
  RolloutRig rig(GetUpRecipe());

  EXPECT_THAT(
      rig.worker->Run(rig.TrainOrder(1, 4), *rig.snapshot).status(),
      StatusIs(absl::StatusCode::kInvalidArgument,
               HasSubstr("a library with a clip that begins on the floor")));
}

TEST(RecoveryRollout, TakesItsAssetsFromBytes) {
  RolloutRig rig(RecoveryRecipe());
  const std::string expected = Bytes(rig.Run(rig.TrainOrder(2, 20)));
  const auto& bytes = rig.asset_bytes;
  const auto assets = RolloutAssets::Create(
      bytes.at("character"), bytes.at("model"), bytes.at("library"),
      bytes.at("frames"), bytes.at("recipe"), bytes.at("fallen"));
  ASSERT_TRUE(assets.ok()) << assets.status();
  rig.assets = *assets;
  rig.NewWorker();

  EXPECT_EQ(Bytes(rig.Run(rig.TrainOrder(2, 20))), expected);
}

TEST(RecoveryRollout, RefusesStatesThatCannotBe) {
  RolloutRig rig(RecoveryRecipe());
  v1::Order order = rig.StandingOrder(1, 4);
  const auto run = [&] {
    return rig.worker->Run(order, *rig.snapshot).status();
  };
  ASSERT_TRUE(run().ok()) << run();

  order.mutable_states(0)->set_recovery_steps_left(7);
  EXPECT_THAT(run(), StatusIs(absl::StatusCode::kInvalidArgument,
                              "order.states[0].recovery_steps_left: expected 0 "
                              "to 6, found 7"));
  order.mutable_states(0)->set_recovery_steps_left(2);
  order.mutable_states(0)->set_frozen_steps(5);
  EXPECT_THAT(run(), StatusIs(absl::StatusCode::kInvalidArgument,
                              "order.states[0].frozen_steps: expected 0 to 0, "
                              "found 5"));
  order.mutable_states(0)->set_frozen_steps(0);
  order.mutable_states(0)->set_goal_distance(-1);
  EXPECT_THAT(run(), StatusIs(absl::StatusCode::kInvalidArgument,
                              HasSubstr("goal_distance: expected >= 0")));
}

v1::Order FallenOrder(const RolloutRig& rig, int steps) {
  v1::Order order = rig.EvaluationOrder({{1, 0, steps}, {1, 0, 10}});
  order.mutable_starts(0)->set_fallen_state(1);
  order.mutable_starts(0)->set_recovery_steps(12);
  return order;
}

TEST(FallenEvaluation, RunsAllItsStepsAndSaysSinceWhenTheBodyStands) {
  RolloutRig rig(RecoveryRecipe());
  rig.UseZeroAction();

  const v1::Segment segment = rig.Run(FallenOrder(rig, 30));

  ASSERT_EQ(segment.results_size(), 2);
  const v1::EvaluationResult& fallen = segment.results(0);
  EXPECT_EQ(fallen.frames(), 30);
  EXPECT_EQ(fallen.fallen_state(), 1);
  EXPECT_EQ(fallen.failed_at_frame(), -1);
  EXPECT_EQ(fallen.success(), fallen.recovered_at_frame() > 0);
  EXPECT_LE(fallen.recovered_at_frame(), 30);
  EXPECT_NE(fallen.recovered_at_frame(), 0);
  const v1::EvaluationResult& standing = segment.results(1);
  EXPECT_FALSE(standing.has_fallen_state());
  EXPECT_TRUE(standing.success());
}

TEST(FallenEvaluation, RefusesStatesThatItHasNotGot) {
  RolloutRig rig;

  EXPECT_THAT(rig.worker->Run(FallenOrder(rig, 19), *rig.snapshot).status(),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("starts[0].fallen_state: expected an index "
                                 "below 0")));
}

TEST(FallenEvaluation, NeedsNoRecoveryInTheRecipe) {
  RolloutRig rig(RecoveryRecipe());
  const auto& bytes = rig.asset_bytes;
  const auto assets = RolloutAssets::Create(
      bytes.at("character"), bytes.at("model"), bytes.at("library"),
      bytes.at("frames"), PrintRecipe(world::testing::ToyRecipe()),
      bytes.at("fallen"));
  ASSERT_TRUE(assets.ok()) << assets.status();
  rig.assets = *assets;
  rig.NewWorker();
  rig.UseZeroAction();
  ASSERT_FALSE(rig.assets->task().recovery().on());

  const v1::Segment segment = rig.Run(FallenOrder(rig, 30));

  ASSERT_EQ(segment.results_size(), 2);
  const v1::EvaluationResult& fallen = segment.results(0);
  EXPECT_EQ(fallen.frames(), 30);
  EXPECT_EQ(fallen.fallen_state(), 1);
  EXPECT_EQ(fallen.failed_at_frame(), -1);
  EXPECT_NE(fallen.recovered_at_frame(), 0);
}

TEST(FallenEvaluation, RefusesRecoveryOfAStartThatHasNotFallen) {
  RolloutRig rig(RecoveryRecipe());
  v1::Order order = rig.EvaluationOrder({{1, 0, 10}});
  order.mutable_starts(0)->set_recovery_steps(3);

  EXPECT_THAT(rig.worker->Run(order, *rig.snapshot).status(),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("starts[0].recovery_steps: expected none "
                                 "without fallen_state, found 3")));
}

}  // namespace
}  // namespace sinew::actor
