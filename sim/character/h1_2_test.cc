#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <mujoco/mujoco.h>

#include <cstdlib>
#include <memory>

#include "common/testing/matchers.h"
#include "sim/character/character.h"
#include "sim/character/gains.h"
#include "sim/character/model_ptr.h"
#include "sim/character/testing/standing.h"

namespace sinew::character {
namespace {

using ::sinew::testing::IsOk;
using ::sinew::testing::StatusIs;
using ::testing::HasSubstr;

// Its MJCF is among the recorded clips.
class H12 : public ::testing::Test {
 protected:
  void SetUp() override {
    if (std::getenv("SINEW_DATA") == nullptr) {
      GTEST_SKIP() << "SINEW_DATA is not set: no model of the H1_2";
    }
    auto loaded = Character::Load("h1_2", v1::Physics());
    ASSERT_THAT(loaded, IsOk());
    robot_ = *std::move(loaded);
    data_.reset(mj_makeData(robot_->model()));
  }

  std::unique_ptr<Character> robot_;
  DataPtr data_;
};

TEST_F(H12, LoadsWithTwentySevenJointsAndNoMesh) {
  EXPECT_EQ(robot_->joints().size(), 27u);
  EXPECT_EQ(robot_->tracked().size(), 14u);
  EXPECT_EQ(robot_->foot_bodies().size(), 2u);
  EXPECT_EQ(robot_->model()->nmesh, 0);
  EXPECT_NEAR(robot_->total_mass(), 67, 4);  // the maker says about 70 kg
}

TEST_F(H12, HasTheGainsThatItsRuleGives) {
  testing::ExpectGains(*robot_, H12GainRule());
}

TEST_F(H12, IsItsOwnMirrorImage) {
  // Centres of torso and wrists lie some millimetres to one side.
  testing::ExpectMirrorImage(*robot_, {.frames = 1e-4, .centres = 6e-3});
}

TEST_F(H12, TouchesTheFloorInItsDefaultPose) {
  testing::Stand(*robot_, data_.get());
  EXPECT_NEAR(testing::LowestSole(*robot_, data_.get()), 0, 0.002);
}

TEST_F(H12, StandsForThreeSecondsOnConstantTargets) {
  testing::Stand(*robot_, data_.get());
  const double height = data_->qpos[2];

  while (data_->time < 3) testing::StepTowardsDefault(*robot_, data_.get());

  EXPECT_NEAR(data_->qpos[2], height, 0.03);
  EXPECT_GT(data_->xmat[9 * robot_->head_body() + 8], 0.98);  // torso upright
}

TEST(H12WithoutData, NamesTheVariableThatIsNotSet) {
  const char* set = std::getenv("SINEW_DATA");
  const std::string folder = set == nullptr ? "" : set;
  unsetenv("SINEW_DATA");

  EXPECT_THAT(Character::Load("h1_2", v1::Physics()),
              StatusIs(absl::StatusCode::kNotFound,
                       HasSubstr("$SINEW_DATA, which is not set")));

  if (set != nullptr) setenv("SINEW_DATA", folder.c_str(), /*overwrite=*/1);
}

}  // namespace
}  // namespace sinew::character
