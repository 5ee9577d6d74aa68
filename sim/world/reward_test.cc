#include "sim/world/reward.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

namespace sinew::world {
namespace {

using ::testing::ElementsAre;

constexpr int kBodies = 4;

v1::Reward Recipe() {
  v1::Reward recipe;
  recipe.set_position_weight(0.5);
  recipe.set_rotation_weight(0.3);
  recipe.set_linear_velocity_weight(0.1);
  recipe.set_angular_velocity_weight(0.1);
  recipe.set_position_kernel(100);
  recipe.set_rotation_kernel(10);
  recipe.set_linear_velocity_kernel(0.1);
  recipe.set_angular_velocity_kernel(0.1);
  return recipe;
}

BodyState State() { return BodyState(kBodies, 2); }

TEST(Reward, IsTheSumOfWeightsOnTheReference) {
  const RewardValue reward = ComputeReward(Recipe(), State(), State(), 100);

  EXPECT_THAT(reward.terms, ElementsAre(1, 1, 1, 1));
  EXPECT_DOUBLE_EQ(reward.total, 1);
}

TEST(Reward, HundredMillimetresOnEveryAxisOfEveryBodyGiveOneOverE) {
  BodyState body = State();
  for (auto& position : body.position) position = {0.1, -0.1, 0.1};

  const RewardValue reward = ComputeReward(Recipe(), body, State(), 0);

  EXPECT_NEAR(reward.terms[0], std::exp(-1), 1e-12);
  EXPECT_NEAR(reward.total, 0.5 * std::exp(-1) + 0.5, 1e-12);
}

TEST(Reward, VelocityTermsTakeTheMeanOverBodiesAndAxes) {
  BodyState body = State();
  body.linear_velocity[1] = {0, 6, 0};    // 36 / (4 * 3) = 3
  body.angular_velocity[2] = {12, 0, 0};  // 144 / 12 = 12

  const RewardValue reward = ComputeReward(Recipe(), body, State(), 0);

  EXPECT_NEAR(reward.terms[2], std::exp(-0.3), 1e-12);
  EXPECT_NEAR(reward.terms[3], std::exp(-1.2), 1e-12);
}

TEST(Reward, RotationTermTakesTheMeanSquaredAngle) {
  BodyState body = State(), reference = State();
  const Eigen::Vector3d axis(0.6, 0, 0.8);
  // 0.4 rad about a slanted axis, between rotations far from the identity.
  reference.rotation[3] = Eigen::AngleAxisd(2.0, Eigen::Vector3d::UnitY());
  body.rotation[3] = Eigen::AngleAxisd(0.4, axis) * reference.rotation[3];

  const RewardValue reward = ComputeReward(Recipe(), body, reference, 0);

  // 0.16 / 4 bodies * kernel 10.
  EXPECT_NEAR(reward.terms[1], std::exp(-0.4), 1e-9);
}

TEST(Reward, DoesNotCareAboutTheSignOfAQuaternion) {
  BodyState body = State();
  body.rotation[0].coeffs() *= -1;

  EXPECT_DOUBLE_EQ(ComputeReward(Recipe(), body, State(), 0).total, 1);
}

TEST(Reward, RotationTermAgreesWithTheTraceOfTheMatrix) {
  BodyState body = State(), reference = State();
  for (int b = 0; b < kBodies; ++b) {
    body.rotation[b] =
        Eigen::Quaterniond(0.3 + b, 0.2, -0.5 * b, 0.4).normalized();
    reference.rotation[b] =
        Eigen::Quaterniond(0.4 + b, 0.3, -0.4 * b, 0.1).normalized();
  }
  double mean = 0;
  for (int b = 0; b < kBodies; ++b) {
    // cos(angle) = (trace - 1) / 2
    const double trace = (reference.rotation[b].toRotationMatrix() *
                          body.rotation[b].toRotationMatrix().transpose())
                             .trace();
    mean += std::pow(std::acos((trace - 1) / 2), 2) / kBodies;
  }

  EXPECT_NEAR(ComputeReward(Recipe(), body, reference, 0).terms[1],
              std::exp(-10 * mean), 1e-9);
}

TEST(Reward, ChargesPower) {
  v1::Reward recipe = Recipe();
  recipe.set_power_cost(0.0005);

  EXPECT_DOUBLE_EQ(ComputeReward(recipe, State(), State(), 400).total, 0.8);
}

}  // namespace
}  // namespace sinew::world
