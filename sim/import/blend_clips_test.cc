#include "sim/import/blend_clips.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <mujoco/mujoco.h>

#include <limits>
#include <utility>
#include <variant>

#include "common/testing/matchers.h"
#include "sim/import/read_clip.h"
#include "sim/import/retarget/dynamics.h"
#include "sim/import/retarget/model_motion.h"
#include "sim/import/retarget/retarget.h"
#include "sim/import/testing/humanoid_fixture.h"
#include "sim/import/testing/made_clips.h"
#include "sim/motion/rotation.h"

namespace sinew::import {
namespace {

using Eigen::Quaterniond;
using Eigen::Vector3d;
using Eigen::VectorXd;
using ::sinew::testing::IsOk;
using ::sinew::testing::StatusIs;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

constexpr auto kInvalid = absl::StatusCode::kInvalidArgument;
constexpr double kRate = 30;
// What is left out of a cycle of the march between its frames 24 and 30.
const BlendOptions kRestOfTheCycle = {.gap_s = 0.2,
                                      .first = {.from_s = 0, .to_s = 0.8}};

Quaterniond Root(const VectorXd& qpos) {
  return motion::FromWxyz(qpos.data() + 3).normalized();
}

class BlendClipsTest : public testing::HumanoidFixture {
 protected:
  // 30 frames that repeat, along x.
  Retargeted March() const {
    const auto source =
        ReadClip("march.txt", testing::MarchJson(), "march", &model_, {});
    EXPECT_THAT(source, IsOk());
    RetargetOptions options;
    options.rate = kRate;
    auto played = RetargetClip(model_, std::get<SourceClip>(*source), options);
    EXPECT_THAT(played, IsOk());
    return *std::move(played);
  }
};

// Another place and another heading: whatever was recorded elsewhere.
ModelMotion Elsewhere(const ModelMotion& motion) {
  ModelMotion moved = motion;
  const Quaterniond turn = motion::YawRotation(2);
  for (VectorXd& qpos : moved.qpos) {
    const Vector3d place = turn * Vector3d(qpos.head<3>());
    qpos.head<3>() = place + Vector3d(5, -3, 0);
    motion::ToWxyz(turn * motion::FromWxyz(qpos.data() + 3), qpos.data() + 3);
  }
  return moved;
}

TEST_F(BlendClipsTest, LeadsOverAsTheMotionItselfWouldHaveGoneOn) {
  const Retargeted march = March();
  ASSERT_EQ(march.motion.frames(), 30);
  Retargeted second = march;
  second.motion = Elsewhere(march.motion);

  const auto blended =
      BlendClips(kRestOfTheCycle, march, second, dynamics_.get());

  ASSERT_THAT(blended, IsOk());
  // Frames 0 to 24, five of the gap, and a whole cycle: two cycles in all.
  ASSERT_EQ(blended->motion.frames(), 60);
  ASSERT_EQ(blended->frames.size(), 60U);
  EXPECT_FALSE(blended->motion.loops);
  for (int t = 0; t < 60; ++t) {
    const VectorXd expected = FrameAt(march.motion, t);
    const VectorXd& found = blended->motion.qpos[t];
    const VectorXd difference = found - expected;
    EXPECT_LT(difference.head<3>().norm(), 0.1) << t;
    EXPECT_LT(motion::AngleBetween(Root(found), Root(expected)), 0.2) << t;
    EXPECT_LT(difference.tail(found.size() - 7).cwiseAbs().maxCoeff(), 0.3)
        << t;
  }
}

TEST_F(BlendClipsTest, VelocitiesGoOnWhereTheGapBeginsAndEnds) {
  const Retargeted march = March();

  const auto blended =
      BlendClips(kRestOfTheCycle, march, march, dynamics_.get());

  ASSERT_THAT(blended, IsOk());
  for (int t = 22; t < 33; ++t) {
    VectorXd qvel, qacc;
    Rates(*model_.model, blended->motion, t, &qvel, &qacc);
    // A jump by one radian per second takes 30 rad/s^2 at this rate.
    EXPECT_LT(qacc.tail(qacc.size() - 6).cwiseAbs().maxCoeff(),
              1.5 * march.quality.peak_joint_acceleration() + 30)
        << t;
    // The root goes on at 0.8 m/s.
    EXPECT_NEAR(qvel.x(), 0.8, 0.4) << t;
  }
}

TEST_F(BlendClipsTest, StandsOnTheFloorAndIsPhysical) {
  const Retargeted march = March();

  const auto blended =
      BlendClips(kRestOfTheCycle, march, march, dynamics_.get());

  ASSERT_THAT(blended, IsOk());
  EXPECT_LT(blended->quality.penetration_max_m(), 0.02);
  EXPECT_LT(blended->quality.floating_mean_m(), 0.01);
  EXPECT_LT(blended->quality.residual_force_bodyweights(), 0.25);
  EXPECT_GT(blended->supported_share, 0.5);
}

TEST_F(BlendClipsTest, FiguresOfTheSourceAreThoseOfBothClips) {
  Retargeted first = March(), second = first;
  const auto set = [](double mean, double max, Retargeted* clip) {
    clip->quality.set_retarget_error_m(mean);
    clip->quality.set_joint_fit_mean_rad(mean);
    clip->quality.set_joint_fit_max_rad(max);
    clip->quality.clear_retarget_errors();
    v1::RetargetError* error = clip->quality.add_retarget_errors();
    error->set_joint("head");
    error->set_mean_m(mean);
    error->set_max_m(max);
  };
  set(0.1, 0.9, &first);
  set(0.3, 0.5, &second);
  second.quality.add_retarget_errors()->set_joint("left_hand");
  first.warnings = {"a"};
  second.warnings = {"b"};
  second.retiming = 1.02;

  const auto blended =
      BlendClips(kRestOfTheCycle, first, second, dynamics_.get());

  ASSERT_THAT(blended, IsOk());
  const v1::ClipQuality& quality = blended->quality;
  EXPECT_NEAR(quality.retarget_error_m(), 0.2, 1e-9);
  EXPECT_NEAR(quality.joint_fit_mean_rad(), 0.2, 1e-9);
  EXPECT_EQ(quality.joint_fit_max_rad(), 0.9);
  ASSERT_EQ(quality.retarget_errors_size(), 2);
  EXPECT_NEAR(quality.retarget_errors(0).mean_m(), 0.2, 1e-9);
  EXPECT_EQ(quality.retarget_errors(0).max_m(), 0.9);
  EXPECT_EQ(quality.retarget_errors(1).joint(), "left_hand");
  EXPECT_THAT(blended->warnings, ElementsAre("a", "b"));
  EXPECT_EQ(blended->retiming, 1.02);
  EXPECT_EQ(blended->map, first.map);
  EXPECT_THAT(blended->source_joints, IsEmpty());
}

TEST_F(BlendClipsTest, RefusesClipsThatCannotBeJoined) {
  const Retargeted march = March();
  Retargeted other = march;
  other.motion.rate = 60;

  EXPECT_THAT(BlendClips({}, march, other, dynamics_.get()),
              StatusIs(kInvalid, HasSubstr("equal rates, found 30 and 60")));
  BlendOptions options;
  options.second = {.from_s = 5, .to_s = 6};  // of one second
  EXPECT_THAT(BlendClips(options, march, march, dynamics_.get()),
              StatusIs(kInvalid, HasSubstr("at least two frames")));
}

TEST(CheckBlendOptions, NamesWhatIsOutOfRange) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(CheckBlendOptions({}), IsOk());
  for (const double gap : {0.0, -1.0, 10.5, kNan}) {
    EXPECT_THAT(
        CheckBlendOptions({.gap_s = gap}),
        StatusIs(kInvalid, HasSubstr("gap of more than 0 and at most 2 s")))
        << gap;
  }
  EXPECT_THAT(CheckBlendOptions({.first = {.from_s = 2, .to_s = 1}}),
              StatusIs(kInvalid, HasSubstr("first clip: expected 0 <= from")));
  EXPECT_THAT(CheckBlendOptions({.second = {.from_s = kNan}}),
              StatusIs(kInvalid, HasSubstr("second clip: expected 0 <= from")));
}

}  // namespace
}  // namespace sinew::import
