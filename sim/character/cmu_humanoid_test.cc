#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <mujoco/mujoco.h>

#include <memory>
#include <set>
#include <string>

#include "common/testing/matchers.h"
#include "sim/character/character.h"
#include "sim/character/gains.h"
#include "sim/character/model_ptr.h"
#include "sim/character/testing/standing.h"

namespace sinew::character {
namespace {

using ::sinew::testing::IsOk;

class CmuHumanoid : public ::testing::Test {
 protected:
  void SetUp() override {
    auto loaded = Character::Load("cmu_humanoid", v1::Physics());
    ASSERT_THAT(loaded, IsOk());
    body_ = *std::move(loaded);
    data_.reset(mj_makeData(body_->model()));
  }

  // Place of a body in the pose of data_.
  const double* Place(const char* body) const {
    return data_->xpos + 3 * mj_name2id(body_->model(), mjOBJ_BODY, body);
  }

  std::unique_ptr<Character> body_;
  DataPtr data_;
};

TEST_F(CmuHumanoid, LoadsWithFiftySixJointsThatAllMeanSomethingElse) {
  EXPECT_EQ(body_->joints().size(), 56u);
  EXPECT_EQ(body_->tracked().size(), 16u);
  EXPECT_EQ(body_->model()->nmesh, 0);
  std::set<std::string> semantics;
  for (const v1::Joint& joint : body_->proto().joints()) {
    semantics.insert(joint.semantic());
  }
  EXPECT_EQ(semantics.size(), 56u);
}

TEST_F(CmuHumanoid, LooksAlongXWithItsLeftSideAlongY) {
  testing::Stand(*body_, data_.get());
  mj_kinematics(body_->model(), data_.get());

  EXPECT_EQ(data_->qpos[3], 1);  // identity
  EXPECT_GT(Place("lfemur")[1], 0.05);
  EXPECT_LT(Place("rfemur")[1], -0.05);
  EXPECT_GT(Place("ltoes")[0], Place("lfoot")[0] + 0.1);
  EXPECT_GT(Place("head")[2], Place("lfoot")[2] + 1.2);
}

TEST_F(CmuHumanoid, HasTheGainsThatItsRuleGives) {
  testing::ExpectGains(*body_, HumanoidGainRule());
}

TEST_F(CmuHumanoid, IsItsOwnMirrorImage) {
  // Its spine leans some millimetres to one side.
  testing::ExpectMirrorImage(*body_, {.frames = 0.01, .centres = 0.01});
}

TEST_F(CmuHumanoid, TouchesTheFloorInItsDefaultPose) {
  testing::Stand(*body_, data_.get());
  EXPECT_NEAR(testing::LowestSole(*body_, data_.get()), 0, 0.002);
}

TEST_F(CmuHumanoid, StandsForTwoSecondsOnConstantTargets) {
  testing::Stand(*body_, data_.get());
  const double height = data_->qpos[2];

  while (data_->time < 2) testing::StepTowardsDefault(*body_, data_.get());

  EXPECT_NEAR(data_->qpos[2], height, 0.05);
  EXPECT_GT(data_->xmat[9 * 1 + 8], 0.98);  // root upright
}

}  // namespace
}  // namespace sinew::character
