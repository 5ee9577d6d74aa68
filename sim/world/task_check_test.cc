#include "sim/world/task_check.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/testing/matchers.h"
#include "sim/character/character.h"
#include "sim/world/testing/toy_world.h"

namespace sinew::world {
namespace {

using ::sinew::testing::IsOk;
using ::sinew::testing::StatusIs;
using ::testing::AllOf;
using ::testing::HasSubstr;

TEST(CheckTask, TakesALibraryOfItsCharacter) {
  const testing::ToyWorld toy = testing::MakeToyWorld();

  EXPECT_THAT(CheckTask(toy.recipe, *toy.character, *toy.library), IsOk());
}

TEST(CheckTask, RefusesClipsOfAnotherCharacterNamingBoth) {
  const testing::ToyWorld toy = testing::MakeToyWorld();
  const auto humanoid =
      character::Character::Load("humanoid", toy.recipe.physics());
  ASSERT_THAT(humanoid, IsOk());

  EXPECT_THAT(CheckTask(toy.recipe, **humanoid, *toy.library),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       AllOf(HasSubstr("(character humanoid)"),
                             HasSubstr("(character toy)"),
                             HasSubstr("import the clips again for this "
                                       "character"))));
}

TEST(CheckTask, RefusesARateThatControlDoesNotMeet) {
  testing::ToyWorld toy = testing::MakeToyWorld();
  toy.recipe.mutable_physics()->set_control_hz(24);

  EXPECT_THAT(CheckTask(toy.recipe, *toy.character, *toy.library),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("frames_per_second: expected 24 "
                                 "(physics.control_hz), found 30")));
}

}  // namespace
}  // namespace sinew::world
