// Inverse dynamics against MuJoCo's own, its derivatives against finite
// differences of it, on every character that comes along.
#include "sim/import/retarget/dynamics.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>

#include "common/testing/matchers.h"
#include "sim/character/character.h"
#include "sim/import/retarget/import_model.h"
#include "sim/motion/rotation.h"

namespace sinew::import {
namespace {

using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

// The lowest point of a ground point's ball, by its body's quaternion.
Vector3d Lowest(const GroundPoint& point, const mjData& data) {
  const Eigen::Quaterniond frame =
      motion::FromWxyz(data.xquat + 4 * point.body);
  return Eigen::Map<const Vector3d>(data.xpos + 3 * point.body) +
         frame * point.position - Vector3d(0, 0, point.radius);
}

class DynamicsTest : public ::testing::TestWithParam<std::string> {
 protected:
  DynamicsTest() {
    auto loaded = character::Character::Load(GetParam(), v1::Physics());
    EXPECT_THAT(loaded, ::sinew::testing::IsOk());
    character_ = *std::move(loaded);
    model_ = MakeImportModel(*character_);
    dynamics_ = std::make_unique<Dynamics>(model_);
    // Springs are part of the law; the characters have none.
    spring_ = character::ModelPtr(mj_copyModel(nullptr, model_.model));
    spring_->jnt_stiffness[4] = 3;
    sprung_ = model_;
    sprung_.model = spring_.get();
  }

  // Anything: turned, bent, moving and accelerating in all coordinates.
  VectorXd Pose() const {
    const mjModel& model = *model_.model;
    VectorXd qpos = Eigen::Map<const VectorXd>(model.qpos0, model.nq);
    VectorXd step = Wave(0.3, 1);
    step.segment<3>(3) = Vector3d(0.4, -0.7, 0.5);
    mj_integratePos(&model, qpos.data(), step.data(), 1);
    return qpos;
  }
  VectorXd Wave(double size, double phase) const {
    VectorXd wave(model_.model->nv);
    for (int i = 0; i < wave.size(); ++i) {
      wave[i] = size * std::sin(1.9 * i + phase);
    }
    return wave;
  }
  VectorXd Moved(const VectorXd& qpos, int dof, double step) const {
    VectorXd moved = qpos;
    const VectorXd change = step * VectorXd::Unit(model_.model->nv, dof);
    mj_integratePos(model_.model, moved.data(), change.data(), 1);
    return moved;
  }

  std::unique_ptr<const character::Character> character_;
  ImportModel model_, sprung_;
  character::ModelPtr spring_;
  std::unique_ptr<Dynamics> dynamics_;
};

TEST_P(DynamicsTest, InverseIsThatOfMuJoCoWithoutContact) {
  const VectorXd qpos = Pose(), qvel = Wave(2, 0.5), qacc = Wave(9, 2);
  Dynamics dynamics(sprung_);
  const mjModel& model = dynamics.model();
  const character::DataPtr data(mj_makeData(&model));
  mju_copy(data->qpos, qpos.data(), model.nq);
  mju_copy(data->qvel, qvel.data(), model.nv);
  mju_copy(data->qacc, qacc.data(), model.nv);
  mj_inverse(&model, data.get());
  const Eigen::Map<const VectorXd> expected(data->qfrc_inverse, model.nv);

  const VectorXd found = dynamics.Inverse(qpos, qvel, qacc);

  EXPECT_GT(expected.norm(), 100);
  EXPECT_NEAR((found - expected).norm(), 0, 1e-9 * expected.norm());
}

TEST_P(DynamicsTest, DerivativesAgreeWithFiniteDifferences) {
  const VectorXd qpos = Pose(), qvel = Wave(2, 0.5), qacc = Wave(9, 2);
  Dynamics dynamics(sprung_);
  const int nv = dynamics.model().nv;
  dynamics.Inverse(qpos, qvel, qacc);
  const InverseDerivatives& derivatives = dynamics.DifferentiateInverse();
  const MatrixXd position = derivatives.position();
  const MatrixXd velocity = derivatives.velocity();
  const MatrixXd acceleration = derivatives.acceleration();
  constexpr double kStep = 1e-5;

  for (int i = 0; i < nv; ++i) {
    const VectorXd step = kStep * VectorXd::Unit(nv, i);
    const auto slope = [&](const VectorXd& more, const VectorXd& less) {
      return ((more - less) / (2 * kStep)).eval();
    };
    const VectorXd by_position =
        slope(dynamics.Inverse(Moved(qpos, i, kStep), qvel, qacc),
              dynamics.Inverse(Moved(qpos, i, -kStep), qvel, qacc));
    const VectorXd by_velocity =
        slope(dynamics.Inverse(qpos, qvel + step, qacc),
              dynamics.Inverse(qpos, qvel - step, qacc));
    const VectorXd by_acceleration =
        slope(dynamics.Inverse(qpos, qvel, qacc + step),
              dynamics.Inverse(qpos, qvel, qacc - step));
    EXPECT_NEAR((position.col(i) - by_position).norm(), 0,
                1e-5 * (1 + by_position.norm()))
        << "dof " << i;
    EXPECT_NEAR((velocity.col(i) - by_velocity).norm(), 0,
                1e-5 * (1 + by_velocity.norm()))
        << "dof " << i;
    EXPECT_NEAR((acceleration.col(i) - by_acceleration).norm(), 0,
                1e-5 * (1 + by_acceleration.norm()))
        << "dof " << i;
  }
}

TEST_P(DynamicsTest, PointsAndJacobiansAreThoseOfMuJoCo) {
  dynamics_->SetPose(Pose());
  const auto lowest = dynamics_->LowestPoints();
  ASSERT_FALSE(lowest.empty());
  Eigen::Matrix<double, 3, Eigen::Dynamic, Eigen::RowMajor> expected(
      3, dynamics_->model().nv);
  double height = INFINITY;
  for (size_t i = 0; i < lowest.size(); ++i) {
    const GroundPoint& point = model_.points[i];
    const int index = static_cast<int>(i);
    EXPECT_NEAR((lowest[i] - Lowest(point, dynamics_->data())).norm(), 0,
                1e-12);
    EXPECT_NEAR(dynamics_->Height(index), lowest[i].z(), 1e-12);
    height = std::min(height, lowest[i].z());
    mj_jac(&dynamics_->model(), &dynamics_->data(), expected.data(), nullptr,
           lowest[i].data(), point.body);
    const MatrixXd found = dynamics_->PointJacobian(point.body, lowest[i]);
    ASSERT_NEAR((found - expected).norm(), 0, 1e-9) << "point " << i;
  }
  EXPECT_NEAR(dynamics_->LowestHeight(), height, 1e-12);
}

INSTANTIATE_TEST_SUITE_P(Characters, DynamicsTest,
                         ::testing::Values("humanoid", "g1"),
                         [](const auto& param) { return param.param; });

}  // namespace
}  // namespace sinew::import
