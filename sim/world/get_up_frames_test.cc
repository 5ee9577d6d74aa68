#include "sim/world/get_up_frames.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <vector>

#include "proto/sinew/v1/recipe.pb.h"
#include "sim/motion/library.h"
#include "sim/world/testing/toy_world.h"

namespace sinew::world {
namespace {

using testing::MakeToyWorld;
using testing::ToyClips;
using testing::ToyRecipe;

TEST(GetUpFrames, AreThoseBelowUprightOfClipsThatEndUpright) {
  const testing::ToyWorld toy = MakeToyWorld(ToyRecipe(), ToyClips::kWithGetUp);
  ASSERT_DOUBLE_EQ(UprightRootHeight(*toy.character), 0.8 * 0.44);

  const std::vector<StartFrame> frames =
      GetUpFrames({}, *toy.character, *toy.library);

  ASSERT_EQ(frames.size(), 7);
  for (int i = 0; i < 7; ++i) {
    EXPECT_EQ(frames[i].clip, 1);
    EXPECT_EQ(frames[i].frame, i);
  }
}

TEST(GetUpFrames, EndWhereTheBodyLeavesTheFloor) {
  const testing::ToyWorld toy = MakeToyWorld(ToyRecipe(), ToyClips::kWithGetUp);
  const auto count = [&](double rise_share) {
    return GetUpFrames({}, *toy.character, *toy.library, rise_share).size();
  };

  // It rises by 0.23 m/s; 0.05 of 0.44 m takes 2.9 frames.
  EXPECT_EQ(count(0.05), 3);
  EXPECT_EQ(count(0), 1);
  EXPECT_EQ(count(1), 7);  // as all that is not upright
}

TEST(GetUpFrames, AreOfClipsThatStartsAreDrawnFrom) {
  const testing::ToyWorld toy = MakeToyWorld(ToyRecipe(), ToyClips::kWithGetUp);
  v1::Start recipe;
  recipe.add_only_clips("turn");
  EXPECT_THAT(GetUpFrames(recipe, *toy.character, *toy.library),
              ::testing::IsEmpty());

  recipe.add_only_clips("sway");
  EXPECT_EQ(GetUpFrames(recipe, *toy.character, *toy.library).size(), 7);
}

TEST(GetUpFrames, AreNotOfClipsThatAreLeftOut) {
  testing::ToyWorld toy = MakeToyWorld(ToyRecipe(), ToyClips::kWithGetUp);
  testing::LeaveOut({1}, toy);

  EXPECT_THAT(GetUpFrames({}, *toy.character, *toy.library),
              ::testing::IsEmpty());
}

TEST(GetUpFrames, AreNoneWhereAllClipsBeginUpright) {
  const testing::ToyWorld toy = MakeToyWorld();

  EXPECT_THAT(GetUpFrames({}, *toy.character, *toy.library),
              ::testing::IsEmpty());
}

TEST(UprightFrames, AreThoseThatStayUpLongEnough) {
  const testing::ToyWorld toy = MakeToyWorld(ToyRecipe(), ToyClips::kWithGetUp);
  v1::Start recipe;
  recipe.add_only_clips("sway");

  const std::vector<StartFrame> frames =
      UprightFrames(recipe, *toy.character, *toy.library, /*seconds=*/5.0 / 30);

  // It is upright from its frame 7 on, and has 20.
  ASSERT_EQ(frames.size(), 8);
  for (int i = 0; i < 8; ++i) {
    EXPECT_EQ(frames[i].clip, 1);
    EXPECT_EQ(frames[i].frame, 7 + i);
  }
  EXPECT_THAT(UprightFrames(recipe, *toy.character, *toy.library),
              ::testing::IsEmpty());
}

TEST(UprightFrames, AreAllOfALoopThatNeverLeadsDown) {
  testing::ToyWorld toy = MakeToyWorld();

  const std::vector<StartFrame> frames =
      UprightFrames({}, *toy.character, *toy.library);

  ASSERT_EQ(frames.size(), 24);
  for (int i = 0; i < 24; ++i) {
    EXPECT_EQ(frames[i].clip, 0);
    EXPECT_EQ(frames[i].frame, i);
  }
  testing::LeaveOut({0}, toy);
  EXPECT_THAT(UprightFrames({}, *toy.character, *toy.library),
              ::testing::IsEmpty());
}

}  // namespace
}  // namespace sinew::world
