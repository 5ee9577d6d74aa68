#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <mujoco/mujoco.h>

#include <memory>

#include "common/testing/matchers.h"
#include "sim/character/character.h"
#include "sim/character/gains.h"
#include "sim/character/model_ptr.h"
#include "sim/character/testing/standing.h"

namespace sinew::character {
namespace {

using ::sinew::testing::IsOk;

std::unique_ptr<Character> LoadG1() {
  auto g1 = Character::Load("g1", v1::Physics());
  EXPECT_THAT(g1, IsOk());
  return *std::move(g1);
}

TEST(G1, LoadsWithTwentyNineJointsAndFourteenTrackedBodies) {
  const auto g1 = LoadG1();

  EXPECT_EQ(g1->joints().size(), 29u);
  EXPECT_EQ(g1->tracked().size(), 14u);
  EXPECT_EQ(g1->foot_geoms()[0].size(), 4u);
  EXPECT_NEAR(g1->total_mass(), 33.3, 0.1);  // the maker says about 35 kg
}

TEST(G1, LeavesMeshesToPictures) {
  const auto g1 = LoadG1();
  const auto pictures = Character::CompileForPictures("g1");

  ASSERT_THAT(pictures, IsOk());
  EXPECT_EQ(g1->model()->nmesh, 0);
  EXPECT_GT((*pictures)->nmesh, 30);
  EXPECT_EQ((*pictures)->nq, g1->model()->nq);
  EXPECT_LT(g1->model_binary().size(), size_t{1} << 20);
}

TEST(G1, HasTheGainsThatItsRuleGives) {
  const auto g1 = LoadG1();
  testing::ExpectGains(*g1, G1GainRule());
}

TEST(G1, IsItsOwnMirrorImage) {
  // The maker's model is symmetric to a tenth of a millimetre, but for the
  // centres of waist and torso.
  testing::ExpectMirrorImage(*LoadG1(), {.frames = 1e-4, .centres = 1e-3});
}

TEST(G1, TouchesTheFloorInItsDefaultPose) {
  const auto g1 = LoadG1();
  const DataPtr data(mj_makeData(g1->model()));
  testing::Stand(*g1, data.get());
  EXPECT_NEAR(testing::LowestSole(*g1, data.get()), 0, 0.002);
}

TEST(G1, StandsForThreeSecondsOnConstantTargets) {
  const auto g1 = LoadG1();
  const DataPtr data(mj_makeData(g1->model()));
  testing::Stand(*g1, data.get());
  const double height = data->qpos[2];

  while (data->time < 3) testing::StepTowardsDefault(*g1, data.get());

  EXPECT_NEAR(data->qpos[2], height, 0.03);
  EXPECT_GT(data->xmat[9 * g1->head_body() + 8], 0.98);  // torso upright
}

TEST(G1, SelfCollisionLeavesTheDefaultPoseFree) {
  v1::Physics physics;
  physics.set_self_collision(true);
  auto g1 = Character::Load("g1", physics);
  ASSERT_THAT(g1, IsOk());
  const DataPtr data(mj_makeData((*g1)->model()));
  testing::Stand(**g1, data.get());
  mj_forward((*g1)->model(), data.get());

  for (int i = 0; i < data->ncon; ++i) {
    EXPECT_EQ(data->contact[i].geom[0], (*g1)->floor_geom());
  }
}

}  // namespace
}  // namespace sinew::character
