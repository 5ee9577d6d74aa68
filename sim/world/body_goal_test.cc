#include "sim/world/body_goal.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "sim/world/observation.h"
#include "sim/world/testing/random_state.h"

namespace sinew::world {
namespace {

using Eigen::Matrix3d;
using Eigen::Quaterniond;
using Eigen::Vector3d;
using testing::Moved;

constexpr int kBodies = 3;

BodyState Draw(int seed) {
  return testing::RandomState(seed, kBodies, /*joints=*/0);
}

std::vector<float> Keypoints(const BodyState& body, const BodyState& goal) {
  std::vector<float> out(kKeypointWidth * kBodies);
  ObservationWriter writer(out.data());
  WriteKeypointGoal(body, goal, Heading(body.rotation[0]), writer);
  EXPECT_EQ(writer.position(), out.data() + out.size());
  return out;
}

std::vector<float> Bodies(const BodyState& body, const BodyState& goal) {
  std::vector<float> out(kBodyGoalWidth * kBodies);
  ObservationWriter writer(out.data());
  WriteBodyGoal(body, goal, Heading(body.rotation[0]), writer);
  EXPECT_EQ(writer.position(), out.data() + out.size());
  return out;
}

void Append(const Vector3d& value, std::vector<double>* out) {
  out->insert(out->end(), {value.x(), value.y(), value.z()});
}

void Append(const Matrix3d& rotation, std::vector<double>* out) {
  Append(Vector3d(rotation.col(0)), out);
  Append(Vector3d(rotation.col(1)), out);
}

// A body that is turned by yaw only has that yaw as its heading, so columns can
// be worked out by matrices alone.
class YawTest : public ::testing::Test {
 protected:
  YawTest() {
    body_.rotation[0] = Quaterniond(Eigen::AngleAxisd(kYaw, Vector3d::UnitZ()));
    to_heading_ << std::cos(kYaw), std::sin(kYaw), 0,  //
        -std::sin(kYaw), std::cos(kYaw), 0,            //
        0, 0, 1;
  }

  static constexpr double kYaw = 2.2;
  BodyState body_ = Draw(1);
  BodyState goal_ = Draw(2);
  Matrix3d to_heading_;
};

TEST_F(YawTest, KeypointsAreWhatTheirDefinitionSays) {
  std::vector<double> expected;
  for (int b = 0; b < kBodies; ++b) {
    Append(Vector3d(to_heading_ * goal_.position[b] -
                    to_heading_ * body_.position[b]),
           &expected);
    Append(Vector3d(to_heading_ * goal_.linear_velocity[b] -
                    to_heading_ * body_.linear_velocity[b]),
           &expected);
    Append(Vector3d(to_heading_ * goal_.position[b] -
                    to_heading_ * body_.position[0]),
           &expected);
  }

  EXPECT_THAT(Keypoints(body_, goal_),
              ::testing::Pointwise(::testing::FloatNear(1e-5F), expected));
}

TEST_F(YawTest, BodyGoalsAreWhatTheirDefinitionSays) {
  std::vector<double> expected;
  for (int b = 0; b < kBodies; ++b) {
    // Rotations as the heading frame has them.
    const Matrix3d goal = to_heading_ * goal_.rotation[b].toRotationMatrix();
    const Matrix3d body = to_heading_ * body_.rotation[b].toRotationMatrix();
    Append(Vector3d(to_heading_ * (goal_.position[b] - body_.position[b])),
           &expected);
    Append(Matrix3d(goal * body.transpose()), &expected);
    Append(Vector3d(to_heading_ *
                    (goal_.linear_velocity[b] - body_.linear_velocity[b])),
           &expected);
    Append(Vector3d(to_heading_ *
                    (goal_.angular_velocity[b] - body_.angular_velocity[b])),
           &expected);
    Append(Vector3d(to_heading_ * (goal_.position[b] - body_.position[0])),
           &expected);
    Append(goal, &expected);
  }

  EXPECT_THAT(Bodies(body_, goal_),
              ::testing::Pointwise(::testing::FloatNear(1e-5F), expected));
}

TEST(BodyGoal, DoesNotDependOnWhereTheWorldIsAndHowItIsTurned) {
  // Heading commutes with turns about the vertical.
  const BodyState body = Draw(3), goal = Draw(4);
  const Vector3d shift(7, -3, 0);
  const BodyState moved_body = Moved(body, 1.3, shift);
  const BodyState moved_goal = Moved(goal, 1.3, shift);

  EXPECT_THAT(
      Keypoints(moved_body, moved_goal),
      ::testing::Pointwise(::testing::FloatNear(2e-5F), Keypoints(body, goal)));
  EXPECT_THAT(
      Bodies(moved_body, moved_goal),
      ::testing::Pointwise(::testing::FloatNear(2e-5F), Bodies(body, goal)));
}

TEST(BodyGoal, KeypointsSeeNoRotation) {
  const BodyState body = Draw(5);
  BodyState goal = Draw(6);
  const std::vector<float> before = Keypoints(body, goal);
  goal.rotation = Draw(7).rotation;
  goal.angular_velocity = Draw(7).angular_velocity;

  EXPECT_EQ(Keypoints(body, goal), before);
}

TEST(BodyGoal, IsABlockOfTheObservationForEachFrameAhead) {
  v1::Observation recipe;
  recipe.add_blocks(v1::Observation::BLOCK_REFERENCE_KEYPOINTS);
  recipe.add_blocks(v1::Observation::BLOCK_REFERENCE_BODIES);
  recipe.add_frames_ahead(1);
  recipe.add_frames_ahead(4);
  const auto builder = ObservationBuilder::Create(recipe, kBodies, 0, 0);
  ASSERT_TRUE(builder.ok()) << builder.status();
  const BodyState body = Draw(1);
  const std::vector<BodyState> goals = {Draw(2), Draw(3)};
  std::vector<float> found(builder->width());
  ObservationInput input;
  input.body = &body;
  input.reference = goals;
  builder->Build(input, absl::MakeSpan(found));

  std::vector<float> expected;
  for (const BodyState& goal : goals) {
    const std::vector<float> part = Keypoints(body, goal);
    expected.insert(expected.end(), part.begin(), part.end());
  }
  for (const BodyState& goal : goals) {
    const std::vector<float> part = Bodies(body, goal);
    expected.insert(expected.end(), part.begin(), part.end());
  }
  EXPECT_EQ(builder->width(), 2 * 3 * (9 + 24));
  EXPECT_EQ(found, expected);

  ObservationNames bodies;
  bodies.bodies = {"root", "left", "right"};
  const std::vector<std::string> names = builder->Names(bodies);
  ASSERT_EQ(names.size(), found.size());
  const std::string& first = bodies.bodies[0];
  EXPECT_EQ(names[0],
            absl::StrCat("keypoint+1/position_difference/", first, "/x"));
  EXPECT_EQ(names[27 + 9 + 5], "keypoint+4/linear_velocity_difference/left/z");
  EXPECT_EQ(names[54 + 23], absl::StrCat("body+1/rotation/", first, "/21"));
  EXPECT_EQ(names.back(), "body+4/rotation/right/21");
}

}  // namespace
}  // namespace sinew::world
