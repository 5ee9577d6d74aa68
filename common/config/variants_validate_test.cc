// Variants of a task in ValidateRecipe and WithDefaults.

#include <limits>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "common/config/recipe.h"
#include "common/config/testing/recipe_assignments.h"
#include "common/testing/matchers.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace sinew {
namespace {

using ::sinew::testing::EqualsProto;
using ::sinew::testing::IsOk;
using ::sinew::testing::MakeRecipe;
using ::sinew::testing::StatusIs;
using ::sinew::testing::Violation;
using ::testing::HasSubstr;

TEST(Variants, AreAbsentFromARecipeThatDoesNotAskForThem) {
  const v1::Task task = MakeRecipe({}).task();

  EXPECT_FALSE(task.has_recovery());
  EXPECT_FALSE(task.has_randomisation());
  EXPECT_FALSE(task.has_actuator_model());
}

TEST(Variants, FillThePapersDefaultsOfRecovery) {
  const v1::Recipe recipe = MakeRecipe({"task.recovery.fallen_share=0.3"});

  EXPECT_THAT(recipe.task().recovery(),
              EqualsProto("fallen_share: 0.3 steps: 90 far_offset: 5 "
                          "far_distance: 3 goal_weight: 9 "
                          "max_gain: 0.3333333333333333 near_distance: 0.25 "
                          "near_factor: 0.5 fallen_states: 256"));
  EXPECT_THAT(ValidateRecipe(recipe), IsOk());
}

TEST(Variants, FillTheStepsOfGetUpsOnlyWhereThereAreAny) {
  const v1::Recovery recovery =
      MakeRecipe({"task.recovery.get_up_share=0.3"}).task().recovery();

  EXPECT_EQ(recovery.get_up_steps(), 20);
  EXPECT_EQ(recovery.steps(), 90);
  EXPECT_DOUBLE_EQ(RecoveryShare(recovery), 0.3);
  EXPECT_DOUBLE_EQ(FallenShare(recovery), 0.3);
}

TEST(Variants, FillTheIntervalOfPushesOnlyWhereTheyAreOn) {
  EXPECT_THAT(
      MakeRecipe({"task.randomisation.mass=0.1"}).task().randomisation(),
      EqualsProto("mass: 0.1"));
  EXPECT_THAT(
      MakeRecipe({"task.randomisation.push_impulse=20"}).task().randomisation(),
      EqualsProto("push_impulse: 20 push_interval: 2 "
                  "push_seconds: 0.1"));
}

TEST(Variants, FillTheHumanoidColumnOfADrive) {
  v1::Recipe recipe;
  auto* drive = recipe.mutable_task()->mutable_actuator_model()->add_drives();
  drive->set_static_friction(0);
  recipe = WithDefaults(recipe);

  EXPECT_THAT(recipe.task().actuator_model(),
              EqualsProto("drives { static_friction: 0 "
                          "activation_velocity: 0.1 viscous_friction: 0.023 "
                          "limit_velocity: 20 max_velocity: 100 }"));
  EXPECT_THAT(ValidateRecipe(recipe), IsOk());
}

class VariantViolation : public ::testing::TestWithParam<Violation> {};

TEST_P(VariantViolation, IsRefusedByNameOfField) {
  EXPECT_THAT(ValidateRecipe(MakeRecipe(GetParam().assignments)),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       absl::StrCat("recipe field ", GetParam().expected)));
}

INSTANTIATE_TEST_SUITE_P(
    Ranges, VariantViolation,
    ::testing::Values(
        Violation{
            {"task.recovery.fallen_share=1.5"},
            "task.recovery.fallen_share: expected within [0, 1], found 1.5"},
        Violation{
            {"task.recovery.fallen_share=0.75", "task.recovery.far_share=0.125",
             "task.recovery.get_up_share=0.25"},
            "task.recovery: expected fallen_share + far_share + get_up_share "
            "at most 1, found 1.125"},
        Violation{{"task.recovery.get_up_share=-0.5"},
                  "task.recovery.get_up_share: expected within [0, 1], found "
                  "-0.5"},
        Violation{
            {"task.recovery.get_up_share=0.5", "task.recovery.get_up_steps=-1"},
            "task.recovery.get_up_steps: expected within [0, 65536], "
            "found -1"},
        Violation{{"task.recovery.far_share=0.5", "task.recovery.steps=-1"},
                  "task.recovery.steps: expected within [1, 65536], found -1"},
        Violation{
            {"task.recovery.far_share=0.5", "task.recovery.near_distance=4"},
            "task.recovery.near_distance: expected <= "
            "task.recovery.far_distance (3), found 4"},
        Violation{{"task.randomisation.mass=1"},
                  "task.randomisation.mass: expected within [0, 0.9], found 1"},
        Violation{
            {"task.randomisation.joint_offset=-0.1"},
            "task.randomisation.joint_offset: expected within [0, 1], found "
            "-0.1"},
        Violation{
            {"task.randomisation.joint_offset=1.5"},
            "task.randomisation.joint_offset: expected within [0, 1], found "
            "1.5"},
        Violation{{"task.randomisation.push_impulse=2000"},
                  "task.randomisation.push_impulse: expected within [0, 1000], "
                  "found 2000"},
        Violation{
            {"task.randomisation.push_interval=4000"},
            "task.randomisation.push_interval: expected within [0, 3600], "
            "found 4000"},
        Violation{{"task.randomisation.push_seconds=4000"},
                  "task.randomisation.push_seconds: expected within [0, 3600], "
                  "found 4000"},
        Violation{{"task.recovery.far_offset=2000"},
                  "task.recovery.far_offset: expected within [0, 1000], found "
                  "2000"},
        Violation{
            {"task.recovery.far_distance=2000"},
            "task.recovery.far_distance: expected within [0, 1000], found "
            "2000"},
        Violation{{"task.randomisation.push_impulse=5",
                   "task.randomisation.push_seconds=3"},
                  "task.randomisation.push_seconds: expected <= "
                  "task.randomisation.push_interval (2), found 3"}));

TEST(Variants, RefuseDrivesThatContradictEachOther) {
  v1::Recipe recipe;
  auto* model = recipe.mutable_task()->mutable_actuator_model();
  model->add_drives()->add_joints("left_knee");
  model->add_drives()->add_joints("left_knee");
  EXPECT_THAT(ValidateRecipe(WithDefaults(recipe)),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       "recipe field task.actuator_model.drives[1].joints: "
                       "expected each joint in one drive only, found "
                       "\"left_knee\""));

  model->mutable_drives(0)->clear_joints();
  model->mutable_drives(1)->clear_joints();
  EXPECT_THAT(ValidateRecipe(WithDefaults(recipe)),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("at most one drive that names no joints")));
}

TEST(Variants, RefuseADriveWhoseNumbersAreNone) {
  v1::Recipe recipe;
  auto* drive = recipe.mutable_task()->mutable_actuator_model()->add_drives();
  drive->set_limit_velocity(7);
  drive->set_max_velocity(7);
  EXPECT_THAT(ValidateRecipe(WithDefaults(recipe)),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("drives[0].max_velocity: expected > ")));

  drive->set_max_velocity(9);
  drive->set_static_friction(std::numeric_limits<double>::quiet_NaN());
  EXPECT_THAT(ValidateRecipe(WithDefaults(recipe)),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("drives[0].static_friction: expected >= 0")));
}

TEST(Variants, AreSetOneByOneButForListsOfGroups) {
  v1::Recipe recipe;

  EXPECT_THAT(SetRecipeField(recipe, "task.actuator_model.drives.joints=a"),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       "--set task.actuator_model.drives.joints: drives is a "
                       "list of groups; expected it in the recipe's file"));
  EXPECT_THAT(SetRecipeField(recipe, "task.actuator_model.drives=a"),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("drives is a list of groups")));
}

}  // namespace
}  // namespace sinew
