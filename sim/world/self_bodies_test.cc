// The block SELF_BODIES of real characters.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <mujoco/mujoco.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "absl/types/span.h"
#include "common/random/philox.h"
#include "sim/character/character.h"
#include "sim/character/model_ptr.h"
#include "sim/world/body_state.h"
#include "sim/world/observation.h"
#include "sim/world/testing/toy_world.h"

namespace sinew::world {
namespace {

constexpr double kPi = std::numbers::pi;

// What a character's own bodies look like in the state of its data.
std::vector<float> Observe(const character::Character& character,
                           mjData* data) {
  v1::Observation recipe;
  recipe.add_blocks(v1::Observation::BLOCK_SELF_BODIES);
  const BodyReader reader(character);
  BodyState state(reader.num_bodies(), reader.num_joints());
  const auto builder = ObservationBuilder::Create(
      recipe, reader.num_bodies(), reader.num_joints(), /*feet=*/2);
  EXPECT_TRUE(builder.ok()) << builder.status();
  std::vector<float> out(builder->width());
  reader.Read(data, &state);
  builder->Build({.body = &state,
                  .reference = {},
                  .reference_contact = {},
                  .previous_target = {},
                  .self_contact = {}},
                 absl::MakeSpan(out));
  return out;
}

void SetHinge(const character::Character& character, const std::string& name,
              double position, double velocity, mjData* data) {
  for (const character::JointInfo& joint : character.joints()) {
    if (joint.name != name) continue;
    data->qpos[joint.qpos_address] = position;
    data->qvel[joint.dof_address] = velocity;
  }
}

TEST(SelfBodies, OfATurningTableAreWhatOneWorksOutByHand) {
  const testing::ToyWorld toy = testing::MakeToyWorld();
  const character::Character& table = *toy.character;
  const character::DataPtr data(mj_makeData(table.model()));
  // It faces y, goes there with 2 m/s, rises with 0.3 m/s and turns to its left
  // with 3 rad/s. A front leg points back, and swings on; a rear one swings.
  const double yaw = kPi / 2;
  const double root[7] = {
      7, -4, 0.5, std::cos(yaw / 2), 0, 0, std::sin(yaw / 2)};
  const double velocity[6] = {0, 2, 0.3, 0, 0, 3};
  std::copy_n(root, 7, data->qpos);
  std::copy_n(velocity, 6, data->qvel);
  SetHinge(table, "hip_fl", kPi / 2, 4, data.get());
  SetHinge(table, "hip_br", 0, -1, data.get());

  const std::vector<float> expected = {
      0.5,  // the root's height
      // Where the hips are: fl, fr, bl, br.
      0.25, 0.2, 0, 0.25, -0.2, 0, -0.25, 0.2, 0, -0.25, -0.2, 0,
      // Trunk; the leg whose x points down; three that stand.
      1, 0, 0, 0, 1, 0,   //
      0, 0, -1, 0, 1, 0,  //
      1, 0, 0, 0, 1, 0, 1, 0, 0, 0, 1, 0, 1, 0, 0, 0, 1, 0,
      // (2, 0, 0.3), and at a hip (x, y) the turn's (-3 y, 3 x, 0) more.
      2, 0, 0.3,        //
      1.4, 0.75, 0.3,   //
      2.6, 0.75, 0.3,   //
      1.4, -0.75, 0.3,  //
      2.6, -0.75, 0.3,  //
      // The turn, and about y what the hinges do.
      0, 0, 3, 0, 4, 3, 0, 0, 3, 0, 0, 3, 0, -1, 3};
  EXPECT_THAT(Observe(table, data.get()),
              ::testing::Pointwise(::testing::FloatNear(1e-6F), expected));
}

TEST(SelfBodies, OfTheHumanoidDoNotDependOnPlaceAndYaw) {
  const auto humanoid =
      character::Character::Load("humanoid", testing::ToyRecipe().physics());
  ASSERT_TRUE(humanoid.ok()) << humanoid.status();
  const mjModel* model = (*humanoid)->model();
  const character::DataPtr data(mj_makeData(model));
  std::vector<float> noise(model->nq + model->nv);
  FillNormal({.seed = 5}, absl::MakeSpan(noise));
  std::copy_n(noise.begin(), model->nq, data->qpos);
  std::copy_n(noise.begin() + model->nq, model->nv, data->qvel);
  mju_normalize4(data->qpos + 3);
  const std::vector<float> before = Observe(**humanoid, data.get());

  const double up[3] = {0, 0, 1};
  double turn[4], position[3], rotation[4], velocity[3];
  mju_axisAngle2Quat(turn, up, 2.2);
  mju_rotVecQuat(position, data->qpos, turn);
  mju_mulQuat(rotation, turn, data->qpos + 3);
  mju_rotVecQuat(velocity, data->qvel, turn);
  const double shift[3] = {40, -7, 0};
  mju_add(data->qpos, position, shift, 3);
  mju_copy(data->qpos + 3, rotation, 4);
  mju_copy(data->qvel, velocity, 3);

  ASSERT_EQ(before.size(), 15 * (*humanoid)->tracked().size() - 2);
  EXPECT_THAT(Observe(**humanoid, data.get()),
              ::testing::Pointwise(::testing::FloatNear(1e-5F), before));
}

}  // namespace
}  // namespace sinew::world
