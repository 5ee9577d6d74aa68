#include "tools/training/student_reach.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <vector>

#include "common/testing/matchers.h"

namespace sinew::tools {
namespace {

using ::sinew::testing::IsOk;
using ::sinew::testing::StatusIs;
using ::testing::AllOf;
using ::testing::HasSubstr;

character::JointInfo Joint(const char* name, double lower, double upper,
                           double default_position, double own_scale = 0) {
  character::JointInfo joint = {};
  joint.name = name;
  joint.stiffness = 100;
  joint.torque_limit = 50;
  joint.lower = lower;
  joint.upper = upper;
  joint.default_position = default_position;
  joint.action_scale = own_scale;
  return joint;
}

v1::Recipe Students(v1::Action::Placement placement, double clip) {
  v1::Recipe recipe;
  v1::Action& student = *recipe.mutable_task()->mutable_action();
  student.set_placement(placement);
  student.set_scale(0.2);
  student.set_clip(clip);
  student.set_range_margin(0.5);
  v1::Action& teacher =
      *recipe.mutable_distillation()->mutable_teacher_action();
  teacher.set_placement(v1::Action::PLACEMENT_AROUND_NEXT_REFERENCE);
  teacher.set_scale(0.4);
  teacher.set_clip(8);
  teacher.set_range_margin(0.25);
  return recipe;
}

constexpr auto kAbsolute = v1::Action::PLACEMENT_ABSOLUTE;
constexpr auto kAroundNext = v1::Action::PLACEMENT_AROUND_NEXT_REFERENCE;
constexpr auto kAroundCurrent = v1::Action::PLACEMENT_AROUND_CURRENT;

TEST(StudentReach, OfAnAbsoluteLawIsTheFartherEndOfEveryJoint) {
  // The knee goes 1.5 up and 2.5 down from its default, margin included.
  const std::vector<character::JointInfo> joints = {
      Joint("hip", -1, 1, 0), Joint("knee", -2, 1.5, 0.25)};

  EXPECT_THAT(CheckReach(Students(kAbsolute, 12.5), joints), IsOk());
  EXPECT_THAT(
      CheckReach(Students(kAbsolute, 12), joints),
      StatusIs(absl::StatusCode::kInvalidArgument,
               AllOf(HasSubstr("task.action.clip: joint knee"),
                     HasSubstr(">= 2.5 rad"), HasSubstr("found 2.4 rad"))));
}

TEST(StudentReach, OfAnAbsoluteLawPassesOverJointsWithoutARange) {
  const double infinity = std::numeric_limits<double>::infinity();

  EXPECT_THAT(CheckReach(Students(kAbsolute, 1),
                         {Joint("wheel", -infinity, infinity, 0)}),
              IsOk());
}

TEST(StudentReach, AroundTheCurrentPoseIsTheWholeRange) {
  const std::vector<character::JointInfo> joints = {Joint("hip", -2, 2, 0)};

  EXPECT_THAT(CheckReach(Students(kAroundCurrent, 21.3), joints), IsOk());
  EXPECT_THAT(CheckReach(Students(kAroundCurrent, 20), joints),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       AllOf(HasSubstr("joint hip"), HasSubstr(">= 4.25 rad"),
                             HasSubstr("found 4 rad"))));
}

TEST(StudentReach, OfTheTeachersLawIsThatOfTheTeacher) {
  const std::vector<character::JointInfo> joints = {Joint("hip", -2, 2, 0)};
  v1::Recipe recipe = Students(kAroundNext, 16);

  EXPECT_THAT(CheckReach(recipe, joints), IsOk());
  EXPECT_THAT(CheckReach(Students(kAroundNext, 15), joints),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       AllOf(HasSubstr("joint hip"), HasSubstr(">= 3.2 rad"),
                             HasSubstr("found 3 rad"))));

  // The reference's torque, which nothing here bounds, is in one base alone.
  recipe.mutable_distillation()
      ->mutable_teacher_action()
      ->set_torque_feedforward(true);
  EXPECT_THAT(CheckReach(recipe, joints),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("task.action: expected the teacher's")));
}

TEST(StudentReach, GoesByTheScaleThatAJointHasOfItsOwn) {
  EXPECT_THAT(
      CheckReach(Students(kAbsolute, 5), {Joint("hip", -1, 1, 0, 0.25)}),
      IsOk());
  EXPECT_THAT(
      CheckReach(Students(kAbsolute, 5), {Joint("hip", -1, 1, 0)}),
      StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr("found 1 rad")));
}

}  // namespace
}  // namespace sinew::tools
