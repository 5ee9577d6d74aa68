#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <mujoco/mujoco.h>

#include <algorithm>
#include <memory>
#include <vector>

#include "common/testing/matchers.h"
#include "sim/character/character.h"
#include "sim/character/gains.h"
#include "sim/character/model_ptr.h"

namespace sinew::character {
namespace {

using ::sinew::testing::IsOk;

std::unique_ptr<Character> LoadG1() {
  auto g1 = Character::Load("g1", v1::Physics());
  EXPECT_THAT(g1, IsOk());
  return *std::move(g1);
}

// Sets the default pose with the soles on the floor.
void Stand(const Character& character, mjData* data) {
  data->qpos[2] = character.proto().standing_root_height();
  for (const JointInfo& joint : character.joints()) {
    data->qpos[joint.qpos_address] = joint.default_position;
  }
}

// One physics step under the torque law of the design, written out anew:
// clamp(kp (q* - q) - kd dq) + kd dq, the damping itself being the model's.
void StepTowardsDefault(const Character& character, mjData* data) {
  for (const JointInfo& joint : character.joints()) {
    const double velocity = data->qvel[joint.dof_address];
    const double torque = joint.stiffness * (joint.default_position -
                                             data->qpos[joint.qpos_address]) -
                          joint.damping * velocity;
    data->qfrc_applied[joint.dof_address] =
        std::clamp(torque, -joint.torque_limit, joint.torque_limit) +
        joint.damping * velocity;
  }
  mj_step(character.model(), data);
}

TEST(G1, LoadsWithTwentyNineJointsAndFourteenTrackedBodies) {
  const auto g1 = LoadG1();

  EXPECT_EQ(g1->joints().size(), 29u);
  EXPECT_EQ(g1->tracked().size(), 14u);
  EXPECT_EQ(g1->foot_geoms()[0].size(), 7u);
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
  const std::vector<Gains> gains =
      ComputeGains(*g1->model(), g1->foot_bodies(), G1GainRule());

  for (const JointInfo& joint : g1->joints()) {
    const Gains& expected = gains[joint.joint_id];
    // Written with four digits.
    EXPECT_NEAR(joint.stiffness / expected.stiffness, 1, 1e-3) << joint.name;
    EXPECT_NEAR(joint.damping / expected.damping, 1, 1e-3) << joint.name;
  }
}

TEST(G1, TouchesTheFloorInItsDefaultPose) {
  const auto g1 = LoadG1();
  const DataPtr data(mj_makeData(g1->model()));
  Stand(*g1, data.get());
  mj_kinematics(g1->model(), data.get());

  double lowest = 1;
  for (const std::vector<int>& sole : g1->foot_geoms()) {
    for (int geom : sole) {
      lowest = std::min(lowest, data->geom_xpos[3 * geom + 2] -
                                    g1->model()->geom_size[3 * geom]);
    }
  }
  EXPECT_NEAR(lowest, 0, 0.002);
}

TEST(G1, StandsForThreeSecondsOnConstantTargets) {
  const auto g1 = LoadG1();
  const DataPtr data(mj_makeData(g1->model()));
  Stand(*g1, data.get());
  const double height = data->qpos[2];

  while (data->time < 3) StepTowardsDefault(*g1, data.get());

  EXPECT_NEAR(data->qpos[2], height, 0.03);
  EXPECT_GT(data->xmat[9 * g1->head_body() + 8], 0.98);  // torso upright
}

TEST(G1, SelfCollisionLeavesTheDefaultPoseFree) {
  v1::Physics physics;
  physics.set_self_collision(true);
  auto g1 = Character::Load("g1", physics);
  ASSERT_THAT(g1, IsOk());
  const DataPtr data(mj_makeData((*g1)->model()));
  Stand(**g1, data.get());
  mj_forward((*g1)->model(), data.get());

  for (int i = 0; i < data->ncon; ++i) {
    EXPECT_EQ(data->contact[i].geom[0], (*g1)->floor_geom());
  }
}

}  // namespace
}  // namespace sinew::character
