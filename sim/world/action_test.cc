#include "sim/world/action.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <limits>
#include <vector>

namespace sinew::world {
namespace {

using ::testing::DoubleEq;
using ::testing::ElementsAre;

// Two joints: kd / kp = 0.1 s and 0.05 s.
std::vector<character::JointInfo> Joints() {
  character::JointInfo knee{};
  knee.stiffness = 100;
  knee.damping = 10;
  knee.torque_limit = 50;
  knee.lower = -1;
  knee.upper = 1;
  knee.default_position = 0.25;
  character::JointInfo hip = knee;
  hip.stiffness = 200;
  hip.lower = -std::numeric_limits<double>::infinity();
  hip.upper = std::numeric_limits<double>::infinity();
  hip.action_scale = 0.5;
  return {knee, hip};
}

v1::Action Recipe() {
  v1::Action recipe;
  recipe.set_scale(0.2);
  recipe.set_clip(2);
  recipe.set_range_margin(0.5);
  return recipe;
}

class ActionLawTest : public ::testing::Test {
 protected:
  ActionLawTest() {
    next_.joint_position = reference_.data();
    next_.joint_velocity = velocity_.data();
    next_.feedforward_torque = torque_.data();
  }

  std::vector<double> Target(const v1::Action& recipe,
                             std::array<float, 2> action) {
    std::vector<double> target(2);
    ActionLaw(recipe, Joints())
        .Target(position_, &next_, action, absl::MakeSpan(target));
    return target;
  }

  const std::array<double, 2> position_ = {0.5, -0.5};
  const std::array<float, 2> reference_ = {0.75F, -0.25F};
  const std::array<float, 2> velocity_ = {2, -4};
  const std::array<float, 2> torque_ = {25, -50};
  motion::FrameView next_{};
};

TEST_F(ActionLawTest, PlacesTargetsAroundTheNextReferenceByDefault) {
  // 0.75 + 0.2 * 1; -0.25 + 0.5 * -1 (the joint's own scale).
  EXPECT_THAT(Target(Recipe(), {1, -1}), ElementsAre(DoubleEq(0.95), -0.75));
}

TEST_F(ActionLawTest, MeasuresActionsByTheStrengthOfAJointIfAsked) {
  v1::Action recipe = Recipe();
  recipe.set_strength_scale(0.25);

  // Knee: 0.75 + 0.25 * 50 / 100; the hip's own scale stays.
  EXPECT_THAT(Target(recipe, {1, -1}), ElementsAre(DoubleEq(0.875), -0.75));
}

TEST_F(ActionLawTest, PlacesTargetsAroundTheBodyOrTheDefaultPose) {
  v1::Action recipe = Recipe();
  recipe.set_velocity_feedforward(true);  // Not around these.
  recipe.set_placement(v1::Action::PLACEMENT_AROUND_CURRENT);
  EXPECT_THAT(Target(recipe, {0, 0}), ElementsAre(0.5, -0.5));

  recipe.set_placement(v1::Action::PLACEMENT_ABSOLUTE);
  EXPECT_THAT(Target(recipe, {0, 0}), ElementsAre(0.25, 0.25));
}

TEST_F(ActionLawTest, FoldsFeedForwardsIntoTheTarget) {
  v1::Action recipe = Recipe();
  recipe.set_velocity_feedforward(true);
  // 0.75 + 0.1 * 2; -0.25 + 0.05 * -4.
  EXPECT_THAT(Target(recipe, {0, 0}),
              ElementsAre(DoubleEq(0.95), DoubleEq(-0.45)));

  recipe.set_torque_feedforward(true);
  // ... + 25 / 100; ... - 50 / 200.
  EXPECT_THAT(Target(recipe, {0, 0}),
              ElementsAre(DoubleEq(1.2), DoubleEq(-0.7)));
}

TEST_F(ActionLawTest, ClipsActionsAndLimitsTargetsToTheWidenedRange) {
  // 0.75 + 0.2 * 2 = 1.15, within 1 + 0.5; -0.25 + 0.5 * 2.
  EXPECT_THAT(Target(Recipe(), {100, 100}), ElementsAre(DoubleEq(1.15), 0.75));

  v1::Action narrow = Recipe();
  narrow.set_range_margin(0);
  EXPECT_THAT(Target(narrow, {2, -2}), ElementsAre(1, -1.25));
}

TEST_F(ActionLawTest, TellsBasesWithoutLimitsAndScales) {
  v1::Action recipe = Recipe();
  recipe.set_velocity_feedforward(true);
  recipe.set_torque_feedforward(true);
  recipe.set_range_margin(0);
  const ActionLaw law(recipe, Joints());
  std::vector<double> base(2);

  // As in FoldsFeedForwardsIntoTheTarget; the knee's range ends at 1.
  law.Base(position_, &next_, absl::MakeSpan(base));
  EXPECT_THAT(base, ElementsAre(DoubleEq(1.2), DoubleEq(-0.7)));
  law.Base(position_, nullptr, absl::MakeSpan(base));
  EXPECT_THAT(base, ElementsAre(0.25, 0.25));
  EXPECT_THAT(law.Scales(), ElementsAre(0.2, 0.5));
}

TEST_F(ActionLawTest, TargetsAreBasesAndScaledActions) {
  for (const auto placement :
       {v1::Action::PLACEMENT_AROUND_NEXT_REFERENCE,
        v1::Action::PLACEMENT_AROUND_CURRENT, v1::Action::PLACEMENT_ABSOLUTE}) {
    v1::Action recipe = Recipe();
    recipe.set_placement(placement);
    const ActionLaw law(recipe, Joints());
    const std::array<float, 2> action = {0.5F, -1.25F};
    std::vector<double> base(2), target(2);

    for (const motion::FrameView* next :
         {static_cast<const motion::FrameView*>(nullptr),
          static_cast<const motion::FrameView*>(&next_)}) {
      law.Base(position_, next, absl::MakeSpan(base));
      law.Target(position_, next, action, absl::MakeSpan(target));
      for (int j = 0; j < 2; ++j) {
        EXPECT_DOUBLE_EQ(target[j], base[j] + law.Scales()[j] * action[j]);
      }
    }
  }
}

TEST_F(ActionLawTest, StartsFromTheBaseOfTheStartFrame) {
  v1::Action recipe = Recipe();
  recipe.set_velocity_feedforward(true);
  std::vector<double> target(2);

  ActionLaw(recipe, Joints())
      .InitialTarget(position_, next_, absl::MakeSpan(target));

  EXPECT_THAT(target, ElementsAre(DoubleEq(0.95), DoubleEq(-0.45)));
}

TEST_F(ActionLawTest, StartsFromTheBodyWhereNotPlacedAroundTheReference) {
  v1::Action recipe = Recipe();
  recipe.set_placement(v1::Action::PLACEMENT_ABSOLUTE);
  std::vector<double> target(2);

  ActionLaw(recipe, Joints())
      .InitialTarget(position_, next_, absl::MakeSpan(target));

  EXPECT_THAT(target, ElementsAre(0.5, -0.5));
}

}  // namespace
}  // namespace sinew::world
