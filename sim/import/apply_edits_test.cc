#include "sim/import/apply_edits.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <mujoco/mujoco.h>

#include <cmath>
#include <limits>
#include <vector>

#include "common/testing/matchers.h"
#include "sim/import/edit.h"
#include "sim/import/retarget/dynamics.h"
#include "sim/import/retarget/quality.h"
#include "sim/import/retarget/retarget.h"
#include "sim/import/testing/humanoid_fixture.h"
#include "sim/motion/rotation.h"

namespace sinew::import {
namespace {

using Eigen::Vector3d;
using Eigen::VectorXd;
using ::sinew::testing::IsOk;
using ::sinew::testing::StatusIs;

constexpr double kRate = 30;
// Where the source's only joint is, seen from the root.
const Vector3d kAhead(0.3, 0.1, 0.2);

class ApplyEditsTest : public testing::HumanoidFixture {
 protected:
  // A second in the rest pose, at a place and a heading that change.
  Retargeted Played() {
    Retargeted played;
    played.motion.rate = kRate;
    for (int t = 0; t < 31; ++t) {
      VectorXd qpos =
          Eigen::Map<const VectorXd>(model_.model->qpos0, model_.model->nq);
      qpos[0] = 1 + 0.01 * t;
      qpos[1] = 2;
      motion::ToWxyz(motion::YawRotation(0.7 + 0.01 * t), qpos.data() + 3);
      played.motion.qpos.push_back(qpos);
      played.source_joints.push_back({SourceJoint(qpos)});
    }
    played.source_parents = {-1};
    played.frames = AnalyseMotion(dynamics_.get(), played.motion);
    played.quality =
        MeasureQuality(dynamics_.get(), played.motion, played.frames);
    return played;
  }

  static Vector3d SourceJoint(const VectorXd& qpos) {
    return Vector3d(qpos.head<3>()) +
           motion::FromWxyz(qpos.data() + 3) * kAhead;
  }

  absl::Status Apply(const EditOptions& options, Retargeted* played) {
    return ApplyEdits(MotionMirror(), options, dynamics_.get(), played);
  }
};

TEST_F(ApplyEditsTest, TheSourceIsTrimmedAndMovedWithTheMotion) {
  Retargeted played = Played();
  EditOptions options;
  options.from_s = 0.2;
  options.to_s = 0.5;
  options.align_heading = true;

  ASSERT_THAT(Apply(options, &played), IsOk());

  ASSERT_EQ(played.motion.frames(), 10);
  ASSERT_EQ(played.source_joints.size(), 10U);
  EXPECT_EQ(played.frames.size(), 10U);
  const VectorXd& first = played.motion.qpos[0];
  EXPECT_NEAR(first.head<2>().norm(), 0, 1e-12);
  EXPECT_NEAR(motion::Yaw(motion::FromWxyz(first.data() + 3)), 0, 1e-12);
  for (int t = 0; t < 10; ++t) {
    const Vector3d expected = SourceJoint(played.motion.qpos[t]);
    EXPECT_NEAR((played.source_joints[t][0] - expected).norm(), 0, 1e-9) << t;
  }
}

TEST_F(ApplyEditsTest, ALoopThatIsMadeHasNoSource) {
  for (const bool loops : {false, true}) {
    Retargeted played = Played();
    played.motion.loops = loops;
    EditOptions options;
    options.loop = true;
    options.to_s = 0.9;

    ASSERT_THAT(Apply(options, &played), IsOk());

    EXPECT_TRUE(played.motion.loops);
    EXPECT_TRUE(played.source_joints.empty()) << loops;
    EXPECT_TRUE(played.source_parents.empty()) << loops;
  }
}

TEST_F(ApplyEditsTest, AWholeLoopKeepsItsSource) {
  Retargeted played = Played();
  played.motion.loops = true;
  EditOptions options;
  options.loop = true;

  ASSERT_THAT(Apply(options, &played), IsOk());

  EXPECT_EQ(played.source_joints.size(), 31U);
}

TEST_F(ApplyEditsTest, SelfPenetrationIsThatOfThePiece) {
  Retargeted played = Played();
  const double own = played.quality.self_penetration_max_m();
  // As if somewhere else in the clip the body were deep in itself.
  played.quality.set_self_penetration_max_m(own + 0.5);
  played.quality.set_retarget_error_m(0.25);
  played.quality.set_self_penetration_added_m(0.125);
  EditOptions options;
  options.from_s = 0.2;
  options.to_s = 0.5;

  ASSERT_THAT(Apply(options, &played), IsOk());

  EXPECT_NEAR(played.quality.self_penetration_max_m(), own, 1e-6);
  // Of the whole clip.
  EXPECT_EQ(played.quality.retarget_error_m(), 0.25);
  EXPECT_EQ(played.quality.self_penetration_added_m(), 0.125);
}

TEST_F(ApplyEditsTest, TimesThatAreNoneAreRefusedAndChangeNothing) {
  for (const double from_s : {-0.2, std::numeric_limits<double>::quiet_NaN(),
                              std::numeric_limits<double>::infinity()}) {
    Retargeted played = Played();
    EditOptions options;
    options.from_s = from_s;
    EXPECT_THAT(Apply(options, &played),
                StatusIs(absl::StatusCode::kInvalidArgument))
        << from_s;
    EXPECT_EQ(played.motion.frames(), 31);
    EXPECT_EQ(played.source_joints.size(), 31U);
  }
  Retargeted played = Played();
  EditOptions options;
  options.to_s = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(Apply(options, &played),
              StatusIs(absl::StatusCode::kInvalidArgument));
}

}  // namespace
}  // namespace sinew::import
