#include "sim/world/actuation.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "sim/world/testing/toy_world.h"

namespace sinew::world {
namespace {

class ActuationTest : public ::testing::Test {
 protected:
  ActuationTest() { Reset(); }

  void Reset() {
    mj_resetData(model(), data_.get());
    data_->qpos[2] = 2;  // in the air
    for (int i = 0; i < model()->nv; ++i) data_->qvel[i] = 0.2 * (i % 3) - 0.1;
  }
  const mjModel* model() const { return toy_.character->model(); }
  absl::Span<const character::JointInfo> joints() const {
    return toy_.character->joints();
  }
  // The clamped PD torque by its definition.
  double PdTorque(size_t j, double target) const {
    const character::JointInfo& joint = joints()[j];
    const double raw =
        joint.stiffness * (target - data_->qpos[joint.qpos_address]) -
        joint.damping * data_->qvel[joint.dof_address];
    return std::clamp(raw, -joint.torque_limit, joint.torque_limit);
  }

  testing::ToyWorld toy_ = testing::MakeToyWorld();
  character::DataPtr data_{mj_makeData(toy_.character->model())};
  std::vector<double> rest_ = {0, 0, 0, 0};
  // The first reaches its torque limit, the others do not.
  std::vector<double> target_ = {1.4, 0.1, -0.1, 0.05};
};

TEST_F(ActuationTest, AppliedAndPassiveForcesAddUpToTheClampedPdTorque) {
  std::vector<double> expected;
  for (size_t j = 0; j < 4; ++j) expected.push_back(PdTorque(j, target_[j]));
  ASSERT_EQ(expected[0], joints()[0].torque_limit);

  Actuation(*toy_.character, /*substeps=*/1, /*ramp=*/false)
      .Run(rest_, target_, data_.get());

  for (size_t j = 0; j < 4; ++j) {
    const int dof = joints()[j].dof_address;
    EXPECT_NEAR(data_->qfrc_applied[dof] + data_->qfrc_passive[dof],
                expected[j], 1e-9)
        << joints()[j].name;
  }
  for (int dof = 0; dof < 6; ++dof) EXPECT_EQ(data_->qfrc_applied[dof], 0);
}

TEST_F(ActuationTest, DampingIsInTheIntegratorEvenAtTheTorqueLimit) {
  // Implicit in velocity: (M + h D) dv = h (force), with force as at v.
  Actuation(*toy_.character, 1, false).Run(rest_, target_, data_.get());
  const std::vector<double> after(data_->qvel, data_->qvel + model()->nv);
  Reset();
  mj_forward(model(), data_.get());
  for (size_t j = 0; j < 4; ++j) {
    data_->qfrc_applied[joints()[j].dof_address] = PdTorque(j, target_[j]);
    data_->qfrc_applied[joints()[j].dof_address] +=
        joints()[j].damping * data_->qvel[joints()[j].dof_address];
  }
  mj_forward(model(), data_.get());
  const int nv = model()->nv;
  const double h = model()->opt.timestep;
  std::vector<double> mass(nv * nv), force(nv), delta(nv);
  mj_fullM(model(), data_.get(), mass.data());
  mju_mulMatVec(force.data(), mass.data(), data_->qacc, nv, nv);
  for (int i = 0; i < nv; ++i) mass[i * nv + i] += h * model()->dof_damping[i];
  mju_cholFactor(mass.data(), nv, 0);
  mju_cholSolve(delta.data(), mass.data(), force.data(), nv);

  for (int i = 0; i < nv; ++i) {
    EXPECT_NEAR(after[i], data_->qvel[i] + h * delta[i], 1e-9) << i;
  }
}

TEST_F(ActuationTest, RampMovesTheTargetInEqualPartsAndReachesIt) {
  const Actuation one(*toy_.character, 1, false);
  for (double share : {0.25, 0.5, 0.75, 1.0}) {
    std::vector<double> part(4);
    for (size_t j = 0; j < 4; ++j) part[j] = share * target_[j];
    one.Run(rest_, part, data_.get());
  }
  const std::vector<double> expected(data_->qpos, data_->qpos + model()->nq);
  Reset();

  Actuation(*toy_.character, 4, true).Run(rest_, target_, data_.get());

  for (int i = 0; i < model()->nq; ++i) {
    EXPECT_DOUBLE_EQ(data_->qpos[i], expected[i]);
  }
}

TEST_F(ActuationTest, ApproachesAnExplicitIntegrationInTinySteps) {
  // The law written down once more, its damping explicit and clamped, in steps
  // so small that implicit or not makes no difference.
  const character::ModelPtr fine(mj_copyModel(nullptr, model()));
  constexpr int kFiner = 200;
  fine->opt.timestep = model()->opt.timestep / kFiner;
  fine->opt.disableflags |= mjDSBL_DAMPER;
  const character::DataPtr exact(mj_makeData(fine.get()));
  const auto distance = [&](int steps) {
    double sum = 0;
    Reset();
    mj_resetData(fine.get(), exact.get());
    mju_copy(exact->qpos, data_->qpos, model()->nq);
    mju_copy(exact->qvel, data_->qvel, model()->nv);
    for (int k = 0; k < steps * kFiner; ++k) {
      for (size_t j = 0; j < joints().size(); ++j) {
        const character::JointInfo& joint = joints()[j];
        exact->qfrc_applied[joint.dof_address] = std::clamp(
            joint.stiffness * (target_[j] - exact->qpos[joint.qpos_address]) -
                joint.damping * exact->qvel[joint.dof_address],
            -joint.torque_limit, joint.torque_limit);
      }
      mj_step(fine.get(), exact.get());
    }
    Actuation(*toy_.character, steps, false).Run(rest_, target_, data_.get());
    for (const character::JointInfo& joint : joints()) {
      sum += std::abs(data_->qpos[joint.qpos_address] -
                      exact->qpos[joint.qpos_address]);
    }
    return sum;
  };
  // The first joint moves by about 0.2 rad in this time, at its torque limit
  // for most of it.
  EXPECT_LT(distance(12), 0.04);
  EXPECT_GT(std::abs(exact->qpos[joints()[0].qpos_address]), 0.1);
}

TEST_F(ActuationTest, ReportsMeanPower) {
  double expected = 0;
  for (size_t j = 0; j < 4; ++j) {
    expected += std::abs(PdTorque(j, target_[j]) *
                         data_->qvel[joints()[j].dof_address]);
  }

  const ActuationResult result =
      Actuation(*toy_.character, 1, false).Run(rest_, target_, data_.get());

  EXPECT_NEAR(result.power, expected, 1e-9);
  EXPECT_FALSE(result.diverged);
}

TEST_F(ActuationTest, SeesDivergence) {
  const Actuation actuation(*toy_.character, 4, false);
  data_->qvel[0] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_TRUE(actuation.Run(rest_, target_, data_.get()).diverged);

  Reset();
  data_->qvel[0] = 2 * Actuation::kMaxSpeed;
  EXPECT_TRUE(actuation.Run(rest_, target_, data_.get()).diverged);

  Reset();
  target_[2] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_TRUE(actuation.Run(rest_, target_, data_.get()).diverged);

  target_[2] = 0;
  Reset();
  EXPECT_FALSE(actuation.Run(rest_, target_, data_.get()).diverged);
}

}  // namespace
}  // namespace sinew::world
