#include "teacher/target_law.h"

#include <limits>
#include <vector>

#include "common/testing/matchers.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "sim/character/character.h"
#include "sim/world/action.h"

namespace sinew::teacher {
namespace {

using ::sinew::testing::IsOk;
using ::sinew::testing::StatusIs;
using ::testing::HasSubstr;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

std::vector<character::JointInfo> MakeJoints() {
  character::JointInfo knee{};
  knee.name = "knee";
  knee.stiffness = 130;
  knee.damping = 10;
  knee.torque_limit = 70;
  knee.lower = -0.3;
  knee.upper = 1.1;
  character::JointInfo hip = knee;
  hip.name = "hip";
  hip.lower = -kInfinity;
  hip.upper = kInfinity;
  character::JointInfo toe = knee;
  toe.name = "toe";
  toe.action_scale = 0.37;
  return {knee, hip, toe};
}

TeacherPolicy MakePolicy(const v1::Action& action) {
  TeacherPolicy policy;
  *policy.manifest.mutable_action() = action;
  for (const character::JointInfo& joint : MakeJoints()) {
    v1::BundleJoint* to = policy.manifest.add_joints();
    to->set_name(joint.name);
    to->set_stiffness(joint.stiffness);
    to->set_torque_limit(joint.torque_limit);
    to->set_lower(joint.lower);
    to->set_upper(joint.upper);
    policy.joint_action_scales.push_back(joint.action_scale);
  }
  policy.manifest.set_action_width(policy.manifest.joints_size());
  return policy;
}

v1::Action MakeAction() {
  v1::Action action;
  // Then the base is what the body's joints are at.
  action.set_placement(v1::Action::PLACEMENT_AROUND_CURRENT);
  action.set_scale(0.2);
  action.set_clip(2);
  action.set_range_margin(0.5);
  return action;
}

TEST(TargetLaw, GivesTheNumbersOfTheWorldsLaw) {
  v1::Action by_strength = MakeAction();
  by_strength.set_strength_scale(0.3);
  for (const v1::Action& action : {MakeAction(), by_strength}) {
    const auto law = TargetLaw::Create(MakePolicy(action));
    ASSERT_THAT(law, IsOk());
    const world::ActionLaw expected(action, MakeJoints());
    // Beyond the clip and the range, and within.
    for (const float unit : {-9.0F, -1.3F, 0.0F, 0.71F, 1.9F, 40.0F}) {
      const std::vector<double> base = {0.9, -0.123, 0.456};
      const std::vector<float> units = {unit, -unit, unit / 3};
      std::vector<double> want(3), found(3);

      expected.Target(base, /*next=*/nullptr, units, absl::MakeSpan(want));
      law->Target(base, units, absl::MakeSpan(found));

      EXPECT_EQ(found, want) << unit;
    }
  }
}

TEST(TargetLaw, FillsTheDefaultsOfOlderManifests) {
  const auto law = TargetLaw::Create(MakePolicy(v1::Action()));
  ASSERT_THAT(law, IsOk());

  EXPECT_EQ(law->scale(0), 0.2);
  EXPECT_EQ(law->scale(2), 0.37);
  EXPECT_EQ(law->action().range_margin(), 1.5);
}

TEST(TargetLaw, RefusesWhatNoBundleHas) {
  TeacherPolicy policy = MakePolicy(MakeAction());
  policy.joint_action_scales.pop_back();
  EXPECT_THAT(TargetLaw::Create(policy),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("one for each of 3 joints, found 2")));

  policy = MakePolicy(MakeAction());
  policy.manifest.set_action_width(4);
  EXPECT_THAT(TargetLaw::Create(policy),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("action_width: expected 3")));

  policy = MakePolicy(MakeAction());
  policy.manifest.mutable_action()->set_strength_scale(1);
  policy.manifest.mutable_joints(1)->set_stiffness(0);
  EXPECT_THAT(TargetLaw::Create(policy),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("joints[1] (hip): radians per unit")));

  policy = MakePolicy(MakeAction());
  policy.manifest.mutable_joints(0)->set_upper(-2);
  EXPECT_THAT(TargetLaw::Create(policy),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("joints[0] (knee).upper")));

  policy = MakePolicy(MakeAction());
  policy.manifest.mutable_action()->set_clip(-1);
  EXPECT_THAT(
      TargetLaw::Create(policy),
      StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr("action.clip")));
}

}  // namespace
}  // namespace sinew::teacher
