#include "tools/bench/actor_figures.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>
#include <utility>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "actor/rollout_assets.h"
#include "common/config/recipe.h"
#include "common/testing/matchers.h"
#include "sim/world/fallen_states.h"
#include "sim/world/testing/toy_world.h"

namespace sinew::bench {
namespace {

using ::sinew::testing::IsOk;
using ::sinew::testing::StatusIs;
using ::testing::HasSubstr;

constexpr ActorOptions kShort = {.threads = 1,
                                 .rounds = 1,
                                 .repetitions = 1,
                                 .environments = 2,
                                 .horizon = 8};

absl::StatusOr<ActorFigures> MeasureToy(v1::Recipe recipe) {
  world::testing::ToyWorld toy =
      world::testing::MakeToyWorld(WithDefaults(std::move(recipe)));
  auto fallen = world::FallenStates::MakeFor(*toy.character, toy.recipe);
  if (!fallen.ok()) return fallen.status();
  const auto assets = actor::RolloutAssets::FromParts(
      toy.recipe, std::move(toy.character), std::move(toy.library),
      *std::move(fallen));
  if (!assets.ok()) return assets.status();
  const auto snapshot = IdlePolicy(**assets);
  if (!snapshot.ok()) return snapshot.status();
  return MeasureActor(kShort, *assets, *snapshot);
}

TEST(ActorFigures, AreMeasuredOnARecipeThatStartsFromTheFloor) {
  v1::Recipe recipe = world::testing::ToyRecipe();
  v1::Recovery* recovery = recipe.mutable_task()->mutable_recovery();
  recovery->set_fallen_share(1);
  recovery->set_fallen_states(2);

  // The plain loop goes through the same states, or this is an error.
  const auto figures = MeasureToy(recipe);

  ASSERT_THAT(figures, IsOk());
  EXPECT_GT(figures->raw_steps_per_s, 0);
  EXPECT_GT(figures->rollout_steps_per_s, 0);
}

TEST(ActorFigures, AreMeasuredOnAComposer) {
  v1::Recipe recipe = world::testing::ToyRecipe();
  recipe.mutable_network()->mutable_composer()->set_primitives(2);

  const auto figures = MeasureToy(recipe);

  ASSERT_THAT(figures, IsOk());
  EXPECT_GT(figures->rollout_steps_per_s, 0);
  EXPECT_GT(figures->products_us, 0);
}

TEST(ActorFigures, AreMeasuredOnALatentThatPpoLearns) {
  v1::Recipe recipe = world::testing::ToyRecipe();
  recipe.mutable_task()->mutable_action()->set_placement(
      v1::Action::PLACEMENT_ABSOLUTE);
  recipe.mutable_network()->mutable_latent()->set_width(3);

  const auto figures = MeasureToy(recipe);

  ASSERT_THAT(figures, IsOk());
  EXPECT_GT(figures->rollout_steps_per_s, 0);
  EXPECT_GT(figures->products_us, 0);
}

TEST(ActorFigures, RefusePhysicsThatThePlainLoopDoesNotKnow) {
  v1::Recipe drives = world::testing::ToyRecipe();
  drives.mutable_task()->mutable_actuator_model()->add_drives();
  v1::Recipe random = world::testing::ToyRecipe();
  random.mutable_task()->mutable_randomisation()->set_mass(0.1);

  EXPECT_THAT(MeasureToy(drives),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("a recipe without task.actuator_model")));
  EXPECT_THAT(MeasureToy(random),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("a recipe without task.randomisation")));
}

}  // namespace
}  // namespace sinew::bench
