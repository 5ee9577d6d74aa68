#include "sim/character/end_effectors.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "common/testing/matchers.h"

namespace sinew::character {
namespace {

using ::sinew::testing::IsOk;
using ::testing::ElementsAre;
using ::testing::UnorderedElementsAre;

std::vector<std::string> Of(const std::string& name) {
  const auto character = Character::Load(name, v1::Physics());
  EXPECT_THAT(character, IsOk());
  const auto names = EndEffectors(**character);
  EXPECT_THAT(names, IsOk());
  return *names;
}

TEST(EndEffectors, AreHandsAndFeetOfEveryCharacter) {
  EXPECT_THAT(Of("humanoid"), UnorderedElementsAre("left_hand", "right_hand",
                                                   "left_foot", "right_foot"));
  EXPECT_THAT(Of("g1"),
              ElementsAre("left_wrist_yaw_link", "right_wrist_yaw_link",
                          "left_ankle_roll_link", "right_ankle_roll_link"));
  EXPECT_THAT(Of("cmu_humanoid"),
              ElementsAre("lhand", "rhand", "lfoot", "rfoot"));
}

}  // namespace
}  // namespace sinew::character
