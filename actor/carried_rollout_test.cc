// Rollouts in which bodies go on where their clip has ended.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>
#include <utility>

#include "actor/testing/rollout_rig.h"
#include "common/config/recipe.h"
#include "common/segment/segment_layout.h"
#include "sim/world/testing/toy_world.h"

namespace sinew::actor {
namespace {

using testing::RolloutRig;

constexpr double kNearlyAll = 0.999;
// Bodies may be so far from the frame that they go on at, m.
constexpr double kAnywhere = 10, kNear = 0.3;

v1::Recipe CarryingRecipe(double share, double distance = kNear) {
  v1::Recipe recipe = world::testing::ToyRecipe();
  recipe.mutable_task()->mutable_termination()->set_max_body_distance(distance);
  recipe.mutable_task()->mutable_start()->set_carry_on_share(share);
  // The clip that bodies go on with has no end of its own.
  recipe.mutable_task()->set_max_episode_steps(40);
  return WithDefaults(recipe);
}

// Of the episodes that came to their clip's end and are followed by another in
// the segment: how many there are, and how many of them were carried on.
struct Onward {
  int ended = 0, carried = 0;
};
Onward CountOnward(const v1::Segment& segment) {
  std::map<std::pair<int64_t, int64_t>, const v1::EpisodeEnd*> episodes;
  for (const v1::EpisodeEnd& end : segment.episodes()) {
    episodes[{end.environment(), end.episode()}] = &end;
  }
  Onward result;
  for (const auto& [key, before] : episodes) {
    const auto found = episodes.find({key.first, key.second + 1});
    if (found == episodes.end()) continue;
    const v1::EpisodeEnd& after = *found->second;
    const bool carried = after.start_kind() == v1::START_KIND_CARRIED;
    if (before->reason() != v1::EpisodeEnd::REASON_CLIP_END) {
      EXPECT_FALSE(carried);
      continue;
    }
    ++result.ended;
    if (!carried) continue;
    ++result.carried;
    // The one clip that stays up for so long.
    EXPECT_EQ(after.clip(), 0);
  }
  return result;
}

TEST(CarriedRollout, GoesOnFromTheEndsOfClips) {
  RolloutRig rig(CarryingRecipe(kNearlyAll, kAnywhere));

  const v1::Segment segment = rig.RunWholeAndInHalves(4, 200);

  const Onward onward = CountOnward(segment);
  EXPECT_GT(onward.ended, 4);
  EXPECT_EQ(onward.carried, onward.ended);
  EXPECT_TRUE(CheckColumnsFinite(segment).ok());
}

TEST(CarriedRollout, DoesNotGoOnWhereNoFrameIsNear) {
  RolloutRig rig(CarryingRecipe(kNearlyAll, kNear));

  const Onward onward = CountOnward(rig.Run(rig.TrainOrder(4, 200)));

  EXPECT_GT(onward.carried, 0);
  EXPECT_LT(onward.carried, onward.ended);
}

TEST(CarriedRollout, GoesOnFromAShareOfThem) {
  RolloutRig some(CarryingRecipe(0.5, kAnywhere));
  RolloutRig none(CarryingRecipe(0, kAnywhere));

  const Onward half = CountOnward(some.Run(some.TrainOrder(4, 400)));
  EXPECT_NEAR(half.carried, 0.5 * half.ended, 0.25 * half.ended);
  const Onward nobody = CountOnward(none.Run(none.TrainOrder(4, 400)));
  EXPECT_GT(nobody.ended, 4);
  EXPECT_EQ(nobody.carried, 0);
}

}  // namespace
}  // namespace sinew::actor
