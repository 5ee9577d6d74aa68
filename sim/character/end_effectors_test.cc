#include "sim/character/end_effectors.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/strings/str_cat.h"
#include "common/files.h"
#include "common/testing/matchers.h"

namespace sinew::character {
namespace {

using ::sinew::testing::IsOk;
using ::sinew::testing::StatusIs;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::UnorderedElementsAre;

std::vector<std::string> Of(const std::string& name) {
  const auto character = Character::Load(name, v1::Physics());
  EXPECT_THAT(character, IsOk());
  const auto names = EndEffectors(**character);
  EXPECT_THAT(names, IsOk());
  return *names;
}

// A body on a trunk of its own, with this name for its one hinge.
absl::StatusOr<std::vector<std::string>> OfOneHinge(const std::string& name) {
  const std::string folder = JoinPath(::testing::TempDir(), name);
  EXPECT_THAT(MakeDirectories(folder), IsOk());
  const std::string model = absl::StrCat(
      R"(<mujoco><worldbody><body name="trunk"><freejoint/><geom size="0.1"/>
         <body name="limb" pos="0 0 -0.3"><joint name=")",
      name, R"(" axis="0 1 0"/><geom size="0.05"/></body>
         </body></worldbody></mujoco>)");
  const std::string text = absl::StrCat(
      R"(format_version: 1 name: "one" model_file: "m.xml" head_body: "trunk"
         standing_root_height: 0.4 actuator_law { derivation: "test" }
         feet { body: "limb" } joints { name: ")",
      name, R"(" stiffness: 10 damping: 1 torque_limit: 5 })");
  EXPECT_THAT(WriteFileAtomically(JoinPath(folder, "m.xml"), model), IsOk());
  const std::string path = JoinPath(folder, "character.textproto");
  EXPECT_THAT(WriteFileAtomically(path, text), IsOk());
  const auto character = Character::Load(path, v1::Physics());
  EXPECT_THAT(character, IsOk());
  return EndEffectors(**character);
}

TEST(EndEffectors, OfABodyWithoutArmsAreRefusedNamingTheSide) {
  EXPECT_THAT(OfOneHinge("left_knee"),
              StatusIs(absl::StatusCode::kFailedPrecondition,
                       HasSubstr("character one: expected a joint with "
                                 "semantic left_wrist or left_elbow")));
  EXPECT_THAT(OfOneHinge("left_elbow"),
              StatusIs(absl::StatusCode::kFailedPrecondition,
                       HasSubstr("right_wrist or right_elbow")));
}

TEST(EndEffectors, AreHandsAndFeetOfTheH12) {
  if (std::getenv("SINEW_DATA") == nullptr) {
    GTEST_SKIP() << "SINEW_DATA is not set: no model of the H1_2";
  }
  EXPECT_THAT(Of("h1_2"),
              ElementsAre("left_wrist_yaw_link", "right_wrist_yaw_link",
                          "left_ankle_roll_link", "right_ankle_roll_link"));
}

TEST(EndEffectors, AreHandsAndFeetOfCharactersThatComeWithTheBuild) {
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
