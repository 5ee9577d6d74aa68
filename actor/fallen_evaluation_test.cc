#include "actor/fallen_evaluation.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <map>
#include <string>
#include <vector>

#include "absl/strings/str_replace.h"
#include "actor/rollout_assets.h"
#include "actor/testing/rollout_rig.h"
#include "common/config/recipe.h"
#include "common/digest.h"
#include "common/policy/safetensors.h"
#include "common/testing/matchers.h"
#include "sim/world/testing/toy_world.h"

namespace sinew::actor {
namespace {

using ::sinew::testing::StatusIs;
using ::testing::HasSubstr;
using testing::RolloutRig;

v1::Recipe RecoveryRecipe() {
  v1::Recipe recipe = world::testing::ToyRecipe();
  v1::Recovery* recovery = recipe.mutable_task()->mutable_recovery();
  recovery->set_fallen_share(0.5);
  recovery->set_steps(12);
  recovery->set_fallen_states(4);
  return WithDefaults(recipe);
}

v1::EvaluationStart GetUpStart() {
  v1::EvaluationStart start;
  start.set_fallen_state(1);
  start.set_steps(30);
  start.set_get_up(true);
  return start;
}

TEST(FallenEvaluation, StartsFromEveryStateInClipsThatAreLongEnough) {
  const RolloutRig rig(RecoveryRecipe());

  // 15 + 15 steps, 12 of which the reference stands: "turn" loops, "sway" has
  // 20 frames, "tumble" has 16 and is too short.
  const auto starts = FallenStarts(rig.assets->task(), 0.5);

  ASSERT_TRUE(starts.ok()) << starts.status();
  ASSERT_EQ(starts->size(), 4);
  for (int i = 0; i < 4; ++i) {
    EXPECT_EQ((*starts)[i].fallen_state(), i);
    EXPECT_EQ((*starts)[i].clip(), i % 2);
    EXPECT_EQ((*starts)[i].steps(), 30);
    EXPECT_EQ((*starts)[i].recovery_steps(), 12);
  }
}

TEST(FallenEvaluation, LeavesOutClipsInWhichTheReferenceLies) {
  RolloutRig rig(RecoveryRecipe());
  std::map<std::string, std::string>& bytes = rig.asset_bytes;
  auto frames = ParseSafetensors(bytes["frames"], "frames");
  ASSERT_TRUE(frames.ok()) << frames.status();
  const auto lower = [&](int row) {
    frames->at("root_position").mutable_float32()[3 * row + 2] = 0.3F;
  };
  lower(7);        // "turn", in use
  lower(24 + 19);  // "sway", after the 19 frames in use
  const std::string before = Sha256Hex(bytes["frames"]);
  bytes["frames"] = SerializeSafetensors(*frames);
  bytes["library"] = absl::StrReplaceAll(
      bytes["library"], {{before, Sha256Hex(bytes["frames"])}});
  const auto assets = RolloutAssets::Create(bytes["character"], bytes["model"],
                                            bytes["library"], bytes["frames"],
                                            bytes["recipe"], bytes["fallen"]);
  ASSERT_TRUE(assets.ok()) << assets.status();

  const auto starts = FallenStarts((*assets)->task(), 0.5);

  ASSERT_TRUE(starts.ok()) << starts.status();
  ASSERT_EQ(starts->size(), 4);
  for (const v1::EvaluationStart& start : *starts) EXPECT_EQ(start.clip(), 1);
}

TEST(FallenEvaluation, StartsCanBeRun) {
  RolloutRig rig(RecoveryRecipe());
  v1::Order order = rig.EvaluationOrder({});
  const auto starts = FallenStarts(rig.assets->task(), 0.5);
  ASSERT_TRUE(starts.ok()) << starts.status();
  order.mutable_starts()->Assign(starts->begin(), starts->end());

  const v1::Segment segment = rig.Run(order);

  ASSERT_EQ(segment.results_size(), 4);
  const std::vector<v1::EvaluationResult> results(segment.results().begin(),
                                                  segment.results().end());
  const double early = RecoveredShare(results, 0.1, 30);
  const double late = RecoveredShare(results, 1, 30);
  EXPECT_LE(early, late);
  int recovered = 0;
  for (const auto& result : results) recovered += result.success() ? 1 : 0;
  EXPECT_DOUBLE_EQ(late, recovered / 4.0);
}

TEST(FallenEvaluation, NeedsFallenStates) {
  const RolloutRig rig;

  EXPECT_THAT(FallenStarts(rig.assets->task(), 5).status(),
              StatusIs(absl::StatusCode::kFailedPrecondition,
                       HasSubstr("an asset of role \"fallen\"")));
}

TEST(GetUpEvaluation, StartsFromEveryStateOnTheNearestGetUp) {
  RolloutRig rig(RecoveryRecipe(), world::testing::ToyClips::kWithGetUp);

  const auto starts = GetUpStarts(rig.assets->task(), 0.5);

  ASSERT_TRUE(starts.ok()) << starts.status();
  ASSERT_EQ(starts->size(), 4);
  v1::Order order = rig.EvaluationOrder({});
  for (int i = 0; i < 4; ++i) {
    EXPECT_EQ((*starts)[i].fallen_state(), i);
    EXPECT_EQ((*starts)[i].steps(), 30);
    EXPECT_EQ((*starts)[i].recovery_steps(), 20);
    EXPECT_TRUE((*starts)[i].get_up());
    *order.add_starts() = (*starts)[i];
  }
  const v1::Segment segment = rig.Run(order);
  ASSERT_EQ(segment.results_size(), 4);
  for (const v1::EvaluationResult& result : segment.results()) {
    EXPECT_EQ(result.clip(), 1);
    EXPECT_LT(result.start_frame(), 7);
    EXPECT_EQ(result.frames(), 30);
    EXPECT_NE(result.recovered_at_frame(), 0);
  }
}

v1::Order LongGetUpOrder(const RolloutRig& rig) {
  v1::Order order = rig.EvaluationOrder({});
  *order.add_starts() = GetUpStart();
  order.mutable_starts(0)->set_steps(100);
  order.mutable_starts(0)->set_recovery_steps(20);
  return order;
}

TEST(GetUpEvaluation, GoesOnWhereTheGetUpIsOver) {
  RolloutRig rig(RecoveryRecipe(), world::testing::ToyClips::kWithGetUp);
  rig.UseZeroAction();

  const v1::Segment segment = rig.Run(LongGetUpOrder(rig));

  ASSERT_EQ(segment.results_size(), 1);
  const v1::EvaluationResult& result = segment.results(0);
  EXPECT_EQ(result.clip(), 1);
  EXPECT_LT(result.start_frame(), 7);
  ASSERT_EQ(result.carried_size(), 1);  // "turn" loops
  EXPECT_EQ(result.carried(0).after_frames(), 20 + 19 - result.start_frame());
  EXPECT_EQ(result.carried(0).clip(), 0);
  EXPECT_LT(result.carried(0).start_frame(), 24);
  EXPECT_EQ(result.frames(), 100);
  EXPECT_EQ(result.velocity_frames(), 98);
  EXPECT_EQ(result.failed_at_frame(), -1);
}

TEST(GetUpEvaluation, FailsWhereThereIsNothingToGoOnWith) {
  v1::Recipe recipe = RecoveryRecipe();
  recipe.mutable_task()->mutable_start()->add_only_clips("sway");
  RolloutRig rig(recipe, world::testing::ToyClips::kWithGetUp);
  rig.UseZeroAction();

  const v1::Segment segment = rig.Run(LongGetUpOrder(rig));

  ASSERT_EQ(segment.results_size(), 1);
  const v1::EvaluationResult& result = segment.results(0);
  EXPECT_EQ(result.frames(), 20 + 19 - result.start_frame());
  EXPECT_EQ(result.failed_at_frame(), result.frames());
  EXPECT_EQ(result.recovered_at_frame(), -1);
  EXPECT_FALSE(result.success());
  EXPECT_EQ(result.carried_size(), 0);
}

TEST(GetUpEvaluation, NeedsAGetUp) {
  RolloutRig rig(RecoveryRecipe());
  EXPECT_THAT(GetUpStarts(rig.assets->task(), 0.5).status(),
              StatusIs(absl::StatusCode::kNotFound,
                       HasSubstr("begins on the floor and ends upright")));

  v1::Order order = rig.EvaluationOrder({});
  *order.add_starts() = GetUpStart();
  EXPECT_THAT(rig.worker->Run(order, *rig.snapshot).status(),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("starts[0].get_up: expected false")));
}

TEST(GetUpEvaluation, RefusesStartsThatMakeNoSense) {
  RolloutRig rig(RecoveryRecipe(), world::testing::ToyClips::kWithGetUp);
  const auto refusal =
      [&](const std::function<void(v1::EvaluationStart*)>& spoil) {
        v1::Order order = rig.EvaluationOrder({});
        *order.add_starts() = GetUpStart();
        spoil(order.mutable_starts(0));
        return std::string(
            rig.worker->Run(order, *rig.snapshot).status().message());
      };

  EXPECT_THAT(refusal([](auto* start) { start->clear_fallen_state(); }),
              HasSubstr("starts[0].get_up: expected false without"));
  EXPECT_THAT(refusal([](auto* start) { start->set_clip(1); }),
              HasSubstr("starts[0].clip: expected 0"));
  EXPECT_THAT(refusal([](auto* start) { start->set_steps(1 << 17); }),
              HasSubstr("starts[0].steps: expected 1 to 65536"));
  EXPECT_EQ(refusal([](auto*) {}), "");
}

TEST(FallenEvaluation, CountsThoseThatAreUpInTimeAndNoOthers) {
  std::vector<v1::EvaluationResult> results(5);
  const int frames[] = {90, 91, -1, 1};
  for (int i = 0; i < 4; ++i) {
    results[i].set_fallen_state(i);
    results[i].set_recovered_at_frame(frames[i]);
  }
  results[4].set_success(true);  // did not start on the floor

  EXPECT_DOUBLE_EQ(RecoveredShare(results, 3, 30), 0.5);
  EXPECT_DOUBLE_EQ(RecoveredShare(results, 5, 30), 0.75);
  EXPECT_EQ(RecoveredShare({}, 5, 30), 0);
}

}  // namespace
}  // namespace sinew::actor
