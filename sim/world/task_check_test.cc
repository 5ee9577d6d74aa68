#include "sim/world/task_check.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>

#include "absl/strings/str_cat.h"
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

TEST(CheckTask, RefusesAClipShorterThanTheWindowOfTheObservation) {
  testing::ToyWorld toy = testing::MakeToyWorld();
  // Its shortest clip, which the one that loops is not.
  const auto& clips = toy.library->manifest().clips();
  const v1::ClipInfo& clip = *std::min_element(
      clips.begin(), clips.end(), [](const auto& a, const auto& b) {
        return a.num_frames() < b.num_frames();
      });
  ASSERT_FALSE(clip.loops());
  const int32_t frames = static_cast<int32_t>(clip.num_frames());
  v1::Observation& observation =
      *toy.recipe.mutable_task()->mutable_observation();
  observation.add_frames_ahead(1);
  observation.add_frames_ahead(frames - 1);
  EXPECT_THAT(CheckTask(toy.recipe, *toy.character, *toy.library), IsOk());
  observation.set_frames_ahead(1, frames);

  EXPECT_THAT(CheckTask(toy.recipe, *toy.character, *toy.library),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       AllOf(HasSubstr(clip.name()),
                             HasSubstr(absl::StrCat("at least ", frames + 1)),
                             HasSubstr(absl::StrCat("found ", frames)))));
  observation.clear_blocks();  // shows no reference
  observation.add_blocks(v1::Observation::BLOCK_SELF_JOINT_SPACE);
  EXPECT_THAT(CheckTask(toy.recipe, *toy.character, *toy.library), IsOk());
}

}  // namespace
}  // namespace sinew::world
