// VMP's actuator model, and bodies that differ from the nominal one.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <string>
#include <vector>

#include "common/config/recipe.h"
#include "common/testing/matchers.h"
#include "sim/world/actuation.h"
#include "sim/world/testing/toy_world.h"

namespace sinew::world {
namespace {

using ::sinew::testing::StatusIs;
using ::testing::HasSubstr;

v1::ActuatorModel MakeModel(const std::string& drives) {
  auto recipe =
      ParseRecipe("task { actuator_model { " + drives + " } }", "test");
  EXPECT_TRUE(recipe.ok()) << recipe.status();
  return WithDefaults(*recipe).task().actuator_model();
}

// The robot column of VMP's table: a leg of the Unitree A1.
constexpr char kLeg[] =
    "drives { static_friction: 0.45 activation_velocity: 0.1 "
    "viscous_friction: 0.023 max_torque: 34 limit_velocity: 7.4 "
    "max_velocity: 20 }";

class ActuatorModelTest : public ::testing::Test {
 protected:
  ActuatorModelTest() { Reset(); }

  void Reset() {
    mj_resetData(model(), data_.get());
    data_->qpos[2] = 2;  // in the air
  }
  const mjModel* model() const { return toy_.character->model(); }
  const character::JointInfo& joint(int j) const {
    return toy_.character->joints()[j];
  }
  absl::StatusOr<Actuation> Create(const std::string& drives, int substeps) {
    return Actuation::Create(MakeModel(drives), *toy_.character, substeps,
                             /*ramp=*/false);
  }
  // Torque that acted on a joint in the step just done.
  double Torque(int j) const {
    const int dof = joint(j).dof_address;
    return data_->qfrc_applied[dof] + data_->qfrc_passive[dof];
  }

  testing::ToyWorld toy_ = testing::MakeToyWorld();
  character::DataPtr data_{mj_makeData(toy_.character->model())};
  std::vector<double> rest_ = {0, 0, 0, 0};
};

struct Point {
  double velocity, motor, torque;
};

TEST_F(ActuatorModelTest, GivesTheTorquesOfEquations9To11) {
  const auto actuation = Create(kLeg, 1);
  ASSERT_TRUE(actuation.ok()) << actuation.status();
  // Target 1.4 at q = 0, kp 200, kd 10: 280 - 10 w before the limit.
  const std::vector<double> target = {1.4, 0, 0, 0};
  const Point points[] = {
      {0, 34, 34},
      // Friction 0.45 tanh(1) + 0.0023.
      {0.1, 34, 33.654983},
      // The limit begins to fall; friction 0.45 + 0.1702.
      {7.4, 34, 33.3798},
      // Half way: 34 (20 - 13.7) / 12.6; friction 0.45 + 0.3151.
      {13.7, 17, 16.2349},
      {20, 0, -0.91},
      {25, 0, -1.025},
      // Braking has all of it, and friction helps.
      {-13.7, 34, 34.7651},
  };
  for (const Point& point : points) {
    Reset();
    data_->qvel[joint(0).dof_address] = point.velocity;

    const ActuationResult result = actuation->Run(rest_, target, data_.get());

    EXPECT_NEAR(Torque(0), point.torque, 1e-6) << point.velocity;
    EXPECT_NEAR(result.power, std::abs(point.motor * point.velocity), 1e-9);
  }
}

TEST_F(ActuatorModelTest, LimitsWhatIsLessThanTheLimitByNothing) {
  const auto actuation = Create(kLeg, 1);
  ASSERT_TRUE(actuation.ok()) << actuation.status();

  // 200 * -0.1; the other way round, with friction at rest.
  actuation->Run(rest_, std::vector<double>{-0.1, 0, 0, 0}, data_.get());

  EXPECT_NEAR(Torque(0), -20, 1e-9);
}

TEST_F(ActuatorModelTest, FrictionSteeperThanAPhysicsStepCanFollowEndsMotion) {
  const auto actuation = Create(
      "drives { static_friction: 5 activation_velocity: 0.01 "
      "viscous_friction: 0 }",
      1);
  ASSERT_TRUE(actuation.ok()) << actuation.status();
  double& velocity = data_->qvel[joint(0).dof_address];
  velocity = 0.05;

  // 5 Nm over one step alone would make it -0.2 or less.
  for (int step = 0; step < 40; ++step) {
    actuation->Run(rest_, rest_, data_.get());
    EXPECT_LT(std::abs(velocity), 0.05) << step;
  }

  EXPECT_LT(std::abs(velocity), 2e-3);
}

TEST_F(ActuatorModelTest, FrictionOfALightJointIsWholeAtSpeed) {
  const auto actuation = Create(
      "drives { static_friction: 5 activation_velocity: 0.01 "
      "viscous_friction: 0 }",
      1);
  ASSERT_TRUE(actuation.ok()) << actuation.status();
  data_->qvel[joint(0).dof_address] = 5;

  // The motor gives 60 at most; at rest target it brakes with 10 * 5.
  actuation->Run(rest_, rest_, data_.get());

  EXPECT_NEAR(Torque(0), -50 - 5, 1e-3);
}

TEST_F(ActuatorModelTest, DrivesAreThoseOfTheirJoints) {
  const auto actuation =
      Create("drives {} drives { joints: \"hip_fr\" max_torque: 4.8 }", 1);
  ASSERT_TRUE(actuation.ok()) << actuation.status();

  actuation->Run(rest_, std::vector<double>{1.4, 1.4, 1.4, 0.1}, data_.get());

  EXPECT_NEAR(Torque(0), 60, 1e-9);  // the character's own limit
  EXPECT_NEAR(Torque(1), 60, 1e-9);
  EXPECT_NEAR(Torque(2), 4.8, 1e-9);
  EXPECT_NEAR(Torque(3), 20, 1e-9);
}

TEST_F(ActuatorModelTest, RefusesDrivesThatDoNotFitTheCharacter) {
  EXPECT_THAT(Create("drives { joints: \"tail\" } drives {}", 1).status(),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       "recipe field task.actuator_model.drives[0].joints: "
                       "expected joints, each once, of character toy, found "
                       "\"tail\""));
  EXPECT_THAT(Create("drives { joints: \"hip_fl\" }", 1).status(),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("expected a drive for every joint of "
                                 "character toy, found none for hip_br")));
}

TEST_F(ActuatorModelTest, WithoutDrivesIsThePlainLaw) {
  const auto none = Create("", 4);
  ASSERT_TRUE(none.ok()) << none.status();
  const std::vector<double> target = {1.4, 0.1, -0.1, 0.05};
  none->Run(rest_, target, data_.get());
  const std::vector<double> found(data_->qpos, data_->qpos + model()->nq);
  Reset();

  Actuation(*toy_.character, 4, false).Run(rest_, target, data_.get());

  EXPECT_EQ(found, std::vector<double>(data_->qpos, data_->qpos + model()->nq));
}

TEST_F(ActuatorModelTest, HasNoStateBesideThePhysicsRow) {
  const auto actuation = Create(kLeg, 4);
  ASSERT_TRUE(actuation.ok()) << actuation.status();
  const std::vector<double> target = {1.4, 0.1, -0.1, 0.05};
  const int size = mj_stateSize(model(), mjSTATE_INTEGRATION);
  std::vector<double> row(size), first(size), second(size);
  actuation->Run(rest_, target, data_.get());
  mj_getState(model(), data_.get(), row.data(), mjSTATE_INTEGRATION);

  actuation->Run(rest_, target, data_.get());
  mj_getState(model(), data_.get(), first.data(), mjSTATE_INTEGRATION);
  for (int i = 0; i < 5; ++i) {
    actuation->Run(target, rest_, data_.get());  // something else
  }
  std::memset(data_->qfrc_passive, 0x7f, sizeof(mjtNum) * model()->nv);
  std::memset(data_->qacc, 0x7f, sizeof(mjtNum) * model()->nv);
  mj_setState(model(), data_.get(), row.data(), mjSTATE_INTEGRATION);
  actuation->Run(rest_, target, data_.get());
  mj_getState(model(), data_.get(), second.data(), mjSTATE_INTEGRATION);

  EXPECT_EQ(first, second);
}

TEST_F(ActuatorModelTest, OffsetsAndGainsOfABodyActOnTheMeasuredError) {
  const std::vector<double> offset = {0.02, 0, 0, 0};
  const std::vector<double> gain = {1.5, 1, 0.5, 1};
  const Actuation actuation(*toy_.character, 1, false);
  data_->qvel[joint(2).dof_address] = 1;

  actuation.Run(rest_, std::vector<double>{0.1, 0.1, 0.1, 1.4},
                {.model = model(), .joint_offset = offset, .gain_scale = gain},
                data_.get());

  EXPECT_NEAR(Torque(0), 24, 1e-9);  // 1.5 * 200 * (0.1 - 0.02)
  EXPECT_NEAR(Torque(1), 20, 1e-9);
  EXPECT_NEAR(Torque(2), 1, 1e-9);   // 0.5 * (100 * 0.1 - 8 * 1)
  EXPECT_NEAR(Torque(3), 60, 1e-9);  // at the limit
}

}  // namespace
}  // namespace sinew::world
