// Figures of quality against motions whose figures are known.
#include "sim/import/retarget/quality.h"

#include <gtest/gtest.h>

#include "sim/import/testing/humanoid_fixture.h"
#include "sim/motion/rotation.h"

namespace sinew::import {
namespace {

using Eigen::Vector3d;
using Eigen::VectorXd;

class QualityTest : public testing::HumanoidFixture {
 protected:
  // The rest pose with its soles on the floor.
  VectorXd Standing() {
    VectorXd qpos = Eigen::Map<const VectorXd>(dynamics_->model().qpos0,
                                               dynamics_->model().nq);
    dynamics_->SetPose(qpos);
    qpos[2] -= dynamics_->LowestHeight();
    return qpos;
  }

  // Turned about the frontmost of the feet's lowest points by `pitch` rad.
  VectorXd OnItsToes(VectorXd qpos, double pitch) {
    dynamics_->SetPose(qpos);
    const FrameDynamics frame =
        AnalyseMotion(dynamics_.get(), Still(qpos)).front();
    Vector3d toe = frame.foot_points.front();
    for (const Vector3d& point : frame.foot_points) {
      if (point.x() > toe.x()) toe = point;
    }
    const Eigen::Quaterniond turn(Eigen::AngleAxisd(pitch, Vector3d::UnitY()));
    const Vector3d root = qpos.head<3>();
    qpos.head<3>() = toe + turn * (root - toe);
    motion::ToWxyz(turn * motion::FromWxyz(qpos.data() + 3), qpos.data() + 3);
    return qpos;
  }

  static ModelMotion Still(const VectorXd& qpos) {
    ModelMotion motion;
    motion.rate = 30;
    motion.qpos = {qpos, qpos, qpos};
    return motion;
  }

  v1::ClipQuality Measure(const ModelMotion& motion) {
    return MeasureQuality(dynamics_.get(), motion,
                          AnalyseMotion(dynamics_.get(), motion));
  }
};

TEST(LargestRise, IsThatOfOneFrame) {
  EXPECT_DOUBLE_EQ(LargestRise({0.1, 0.2, 0.0}, {0.0, 0.25, 0.02}), 0.05);
  EXPECT_EQ(LargestRise({0.1, 0.2}, {0.1, 0.1}), 0);
}

TEST_F(QualityTest, FeetThatStandDoNotSkate) {
  const v1::ClipQuality quality = Measure(Still(Standing()));
  EXPECT_EQ(quality.foot_skate_m_per_s(), 0);
  EXPECT_NEAR(quality.foot_penetration_p99_m(), 0, 1e-9);
  EXPECT_EQ(quality.airborne_share(), 0);
}

TEST_F(QualityTest, ABodyPushedOverTheFloorSkatesAtItsSpeed) {
  ModelMotion motion;
  motion.rate = 30;
  for (int t = 0; t < 10; ++t) {
    motion.qpos.push_back(Standing());
    motion.qpos.back()[0] = 0.01 * t;  // 0.3 m/s
  }
  EXPECT_NEAR(Measure(motion).foot_skate_m_per_s(), 0.3, 1e-9);
}

TEST_F(QualityTest, AFootThatRollsOverItsToeStands) {
  ModelMotion motion;
  motion.rate = 30;
  for (int t = 0; t < 5; ++t) {
    motion.qpos.push_back(OnItsToes(Standing(), 0.01 * t));
  }
  const v1::ClipQuality quality = Measure(motion);
  EXPECT_LT(quality.foot_skate_m_per_s(), 0.005);
  EXPECT_NEAR(quality.peak_root_speed(), 0.3, 0.1);  // it does move
}

TEST_F(QualityTest, DepthBelowTheFloorIsThatOfTheFeet) {
  VectorXd qpos = Standing();
  qpos[2] -= 0.03;
  const v1::ClipQuality quality = Measure(Still(qpos));
  EXPECT_NEAR(quality.foot_penetration_p99_m(), 0.03, 1e-9);
  EXPECT_NEAR(quality.penetration_max_m(), 0.03, 1e-9);
}

TEST_F(QualityTest, NothingTouchesTheFloorInFlight) {
  VectorXd qpos = Standing();
  qpos[2] += 0.5;
  const v1::ClipQuality quality = Measure(Still(qpos));
  EXPECT_EQ(quality.airborne_share(), 1);
  EXPECT_EQ(quality.foot_skate_m_per_s(), 0);
  EXPECT_NEAR(quality.residual_force_bodyweights(), 1, 1e-6);
}

}  // namespace
}  // namespace sinew::import
