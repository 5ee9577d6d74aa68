#include "sim/character/gains.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "sim/character/model_ptr.h"

namespace sinew::character {
namespace {

// Point masses on massless rods, so that every figure is plain arithmetic. A
// pelvis of 10 kg on two legs: thighs of 2 kg, shins of 1 kg whose ends are the
// feet, all masses at the lower end of a rod of 0.5 m; an arm of 3 kg held
// sideways; a mast of 4 kg that stands up.
constexpr char kModel[] = R"(<mujoco>
  <compiler angle="radian" boundinertia="0"/>
  <default><geom contype="0" conaffinity="0"/></default>
  <worldbody><body name="pelvis" pos="0 0 1"><freejoint/>
    <inertial pos="0 0 0" mass="10" diaginertia="1e-9 1e-9 1e-9"/>
    <body name="left_thigh">
      <joint name="left_hip" axis="0 1 0" armature="0.5"/>
      <inertial pos="0 0 -.5" mass="2" diaginertia="1e-9 1e-9 1e-9"/>
      <body name="left_shin" pos="0 0 -.5">
        <joint name="left_knee" axis="0 1 0"/>
        <joint name="left_twist" axis="0 0 1"/>
        <inertial pos="0 0 -.5" mass="1" diaginertia="1e-9 1e-9 1e-9"/>
      </body></body>
    <body name="right_thigh">
      <joint name="right_hip" axis="0 1 0" armature="0.5"/>
      <inertial pos="0 0 -.5" mass="2" diaginertia="1e-9 1e-9 1e-9"/>
      <body name="right_shin" pos="0 0 -.5">
        <joint name="right_knee" axis="0 1 0"/>
        <inertial pos="0 0 -.5" mass="1" diaginertia="1e-9 1e-9 1e-9"/>
      </body></body>
    <body name="arm">
      <joint name="shoulder" axis="1 0 0"/>
      <inertial pos="0 2 0" mass="3" diaginertia="1e-9 1e-9 1e-9"/>
    </body>
    <body name="mast">
      <joint name="waist" axis="0 1 0"/>
      <inertial pos="0 0 .5" mass="4" diaginertia="1e-9 1e-9 1e-9"/>
    </body>
  </body></worldbody></mujoco>)";
constexpr double kGravity = 9.81;

class GainsTest : public ::testing::Test {
 protected:
  void SetUp() override {
    char error[500] = "";
    mjSpec* spec = mj_parseXMLString(kModel, nullptr, error, sizeof(error));
    ASSERT_NE(spec, nullptr) << error;
    model_.reset(mj_compile(spec, nullptr));
    mj_deleteSpec(spec);
    ASSERT_NE(model_, nullptr);
  }

  int Joint(const char* name) const {
    return mj_name2id(model_.get(), mjOBJ_JOINT, name);
  }
  std::vector<Gains> Compute(const GainRule& rule) const {
    return ComputeGains(*model_,
                        {mj_name2id(model_.get(), mjOBJ_BODY, "left_shin"),
                         mj_name2id(model_.get(), mjOBJ_BODY, "right_shin")},
                        rule);
  }

  ModelPtr model_;
};

TEST_F(GainsTest, AreInertiaTimesSquaredBandwidthForAFreeLimb) {
  const auto gains = Compute({.bandwidth = 5, .damping_ratio = 1});

  // I = 3 kg (2 m)^2 = 12, kp = 12 * 25, kd = 2 * 300 / 5.
  EXPECT_NEAR(gains[Joint("shoulder")].stiffness, 300, 1e-5);
  EXPECT_NEAR(gains[Joint("shoulder")].damping, 120, 1e-5);
}

TEST_F(GainsTest, HoldTheLoadOfALegWithTheMargin) {
  const auto gains = Compute({.bandwidth = 0.1, .stability_margin = 2});

  // Above the knees, at 0.5 m: pelvis 10 kg and arm 3 kg at +0.5 m, mast 4 kg
  // at +1 m, thighs at 0: (13 * 0.5 + 4) g, margin 2, 2 feet.
  EXPECT_NEAR(gains[Joint("left_knee")].stiffness, 10.5 * kGravity, 1e-6);
  EXPECT_NEAR(gains[Joint("right_knee")].stiffness, 10.5 * kGravity, 1e-6);
  // Above the hips: only the mast, 4 kg at 0.5 m.
  EXPECT_NEAR(gains[Joint("left_hip")].stiffness, 2 * kGravity, 1e-6);
}

TEST_F(GainsTest, HoldWhatStandsOnAJointOutsideTheLegs) {
  const auto gains = Compute({.bandwidth = 0.1, .stability_margin = 2});

  EXPECT_NEAR(gains[Joint("waist")].stiffness, 2 * 4 * 0.5 * kGravity, 1e-6);
}

TEST_F(GainsTest, AreSharedByTheHingesOfABody) {
  const auto gains = Compute({.bandwidth = 0.1});

  EXPECT_EQ(gains[Joint("left_twist")].stiffness,
            gains[Joint("left_knee")].stiffness);
}

TEST_F(GainsTest, CountTheDriveAloneWhereTheRuleSaysSo) {
  const auto gains = Compute({.inertia = GainRule::Inertia::kArmature,
                              .bandwidth = 10,
                              .damping_ratio = 2,
                              .stability_margin = 0,
                              .least_inertia = 0.1});

  EXPECT_NEAR(gains[Joint("left_hip")].stiffness, 0.5 * 100, 1e-9);
  EXPECT_NEAR(gains[Joint("left_hip")].damping, 2 * 2 * 50 / 10.0, 1e-9);
  EXPECT_NEAR(gains[Joint("shoulder")].stiffness, 0.1 * 100, 1e-9);
}

}  // namespace
}  // namespace sinew::character
