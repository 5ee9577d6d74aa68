#include "sim/world/body_state.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <numbers>
#include <string>
#include <vector>

#include "common/files.h"
#include "common/random/philox.h"
#include "common/testing/matchers.h"
#include "sim/world/testing/toy_world.h"
#include "sim/world/tracking_task.h"

namespace sinew::world {
namespace {

using Eigen::AngleAxisd;
using Eigen::Quaterniond;
using Eigen::Vector3d;
using ::sinew::testing::IsOk;

Quaterniond Turn(double angle, const Vector3d& axis) {
  return Quaterniond(AngleAxisd(angle, axis.normalized()));
}

TEST(Heading, OfATurnAboutTheVerticalIsThatTurn) {
  for (double yaw : {-3.0, -0.5, 0.0, 1.0, 2.5}) {
    const Quaterniond turn = Turn(yaw, Vector3d::UnitZ());
    EXPECT_LT(Heading(turn).angularDistance(turn), 1e-12) << yaw;
  }
}

TEST(Heading, DoesNotSeeTilt) {
  const Quaterniond yaw = Turn(0.7, Vector3d::UnitZ());
  for (double tilt : {0.3, 1.6, 3.0}) {
    const Quaterniond rotation = yaw * Turn(tilt, {0.6, -0.8, 0});
    EXPECT_LT(Heading(rotation).angularDistance(yaw), 1e-9) << tilt;
  }
}

TEST(Heading, IsTheIdentityUpsideDown) {
  EXPECT_EQ(Heading(Turn(std::numbers::pi, Vector3d::UnitX())).w(), 1);
}

// A state of the toy with every coordinate and speed in use.
void SetBusyState(const mjModel* model, mjData* data) {
  for (int i = 0; i < model->nq; ++i) data->qpos[i] = 0.3 + 0.1 * (i % 4);
  mju_normalize4(data->qpos + 3);
  for (int i = 0; i < model->nv; ++i) data->qvel[i] = 1.5 - 0.4 * i;
}

// What Read gives after moving along qvel for `dt` seconds.
BodyState StateAfter(const BodyReader& reader, const mjModel* model,
                     double dt) {
  const character::DataPtr data(mj_makeData(model));
  SetBusyState(model, data.get());
  mj_integratePos(model, data->qpos, data->qvel, dt);
  BodyState state(reader.num_bodies(), reader.num_joints());
  reader.Read(data.get(), &state);
  return state;
}

TEST(BodyReader, VelocitiesAreThoseOfFrameOriginsByFiniteDifferences) {
  const testing::ToyWorld toy = testing::MakeToyWorld();
  const BodyReader reader(*toy.character);
  const mjModel* model = toy.character->model();
  const double dt = 1e-5;

  const BodyState now = StateAfter(reader, model, 0);
  const BodyState before = StateAfter(reader, model, -dt);
  const BodyState after = StateAfter(reader, model, dt);

  for (int b = 0; b < reader.num_bodies(); ++b) {
    const Vector3d linear = (after.position[b] - before.position[b]) / (2 * dt);
    const AngleAxisd turn(after.rotation[b] * before.rotation[b].conjugate());
    const Vector3d angular = turn.axis() * turn.angle() / (2 * dt);
    EXPECT_LT((linear - now.linear_velocity[b]).norm(), 1e-6) << b;
    EXPECT_LT((angular - now.angular_velocity[b]).norm(), 1e-6) << b;
  }
}

// The frame of a body as MuJoCo sees it; data has positions and velocities.
void ExpectMotionOf(const mjModel* model, const mjData* data, int id,
                    const BodyState& state, int b) {
  double velocity[6];  // angular, then linear
  mj_objectVelocity(model, data, mjOBJ_XBODY, id, velocity, /*flg_local=*/0);
  const double* q = data->xquat + 4 * id;
  const Quaterniond rotation(q[0], q[1], q[2], q[3]);
  for (int i = 0; i < 3; ++i) {
    EXPECT_NEAR(state.position[b][i], data->xpos[3 * id + i], 1e-13) << id;
    EXPECT_NEAR(state.angular_velocity[b][i], velocity[i], 1e-12) << id;
    EXPECT_NEAR(state.linear_velocity[b][i], velocity[3 + i], 1e-12) << id;
  }
  EXPECT_LT((state.rotation[b].coeffs() - rotation.coeffs()).norm(), 1e-13)
      << id;
}

// Reads twenty states drawn at random and holds them against MuJoCo's.
void ExpectAgreementInAnyState(const character::Character& character) {
  const mjModel* model = character.model();
  const BodyReader reader(character);
  const character::DataPtr data(mj_makeData(model));
  BodyState state(reader.num_bodies(), reader.num_joints());
  std::vector<float> noise(model->nq + model->nv);

  for (uint64_t seed = 1; seed <= 20; ++seed) {
    FillNormal({.seed = seed}, absl::MakeSpan(noise));
    std::copy_n(noise.begin(), model->nq, data->qpos);
    std::copy_n(noise.begin() + model->nq, model->nv, data->qvel);
    mju_normalize4(data->qpos + 3);
    reader.Read(data.get(), &state);

    mj_kinematics(model, data.get());
    mj_comPos(model, data.get());
    mj_comVel(model, data.get());
    for (int b = 0; b < reader.num_bodies(); ++b) {
      ExpectMotionOf(model, data.get(), character.tracked()[b] + 1, state, b);
    }
  }
}

class BodyReaderOfCharacterTest : public ::testing::TestWithParam<const char*> {
};

TEST_P(BodyReaderOfCharacterTest, AgreesWithMuJoCoInAnyState) {
  const auto character = character::Character::Load(GetParam(), v1::Physics());
  ASSERT_THAT(character, IsOk());
  ExpectAgreementInAnyState(**character);
}

INSTANTIATE_TEST_SUITE_P(Characters, BodyReaderOfCharacterTest,
                         ::testing::Values("humanoid", "g1"),
                         [](const auto& info) { return info.param; });

// A crane whose hinges turn about points off their bodies' origins, one of them
// with an angle other than 0 at rest; a turned body hangs below.
constexpr char kCraneModel[] = R"(<mujoco><worldbody><body name="root">
  <freejoint/><geom size="0.1"/>
  <body name="boom" pos="0.1 0 0.2" quat="0.9 0.1 -0.3 0.2">
    <joint name="turn" axis="0 1 0" pos="0.02 0.03 0.05" ref="10"/>
    <joint name="lift" axis="1 0 1" pos="-0.04 0 0.01"/>
    <geom size="0.05"/>
    <body name="hook" pos="0 0.3 0" quat="0.7 0 0.7 0.1">
      <joint name="swing" axis="0 0.6 0.8"/>
      <geom size="0.04"/>
    </body></body></body></worldbody></mujoco>)";
constexpr char kCrane[] = R"(format_version: 1 name: "crane"
  model_file: "crane.xml" head_body: "root" standing_root_height: 0.4
  actuator_law { derivation: "test" } feet { body: "hook" }
  joints { name: "turn" stiffness: 10 damping: 1 torque_limit: 5 }
  joints { name: "lift" stiffness: 10 damping: 1 torque_limit: 5 }
  joints { name: "swing" stiffness: 10 damping: 1 torque_limit: 5 })";

TEST(BodyReader, AgreesWithMuJoCoWhereHingesLieOffTheirBodies) {
  const std::string folder = JoinPath(::testing::TempDir(), "crane");
  ASSERT_THAT(MakeDirectories(folder), IsOk());
  ASSERT_THAT(WriteFileAtomically(JoinPath(folder, "crane.xml"), kCraneModel),
              IsOk());
  const std::string path = JoinPath(folder, "character.textproto");
  ASSERT_THAT(WriteFileAtomically(path, kCrane), IsOk());
  const auto character = character::Character::Load(path, v1::Physics());
  ASSERT_THAT(character, IsOk());
  const mjModel* model = (*character)->model();
  ASSERT_GT(model->qpos0[7], 0.1);  // the angle at rest
  ASSERT_EQ((*character)->tracked().size(), 3u);

  ExpectAgreementInAnyState(**character);
}

TEST(BodyReader, ReadsThePhysicsRowAlone) {
  const testing::ToyWorld toy = testing::MakeToyWorld();
  const BodyReader reader(*toy.character);
  const mjModel* model = toy.character->model();
  const BodyState expected = StateAfter(reader, model, 0);
  const character::DataPtr data(mj_makeData(model));
  SetBusyState(model, data.get());
  std::fill_n(data->xpos, 3 * model->nbody, 7.0);
  std::fill_n(data->xquat, 4 * model->nbody, 7.0);
  std::fill_n(data->cvel, 6 * model->nbody, 7.0);

  BodyState state(reader.num_bodies(), reader.num_joints());
  reader.Read(data.get(), &state);

  EXPECT_EQ(state.position, expected.position);
  EXPECT_EQ(state.rotation, expected.rotation);
  EXPECT_EQ(state.linear_velocity, expected.linear_velocity);
  EXPECT_EQ(state.angular_velocity, expected.angular_velocity);
  EXPECT_EQ(data->xpos[3], 7);
}

TEST(BodyReader, AgreesWithTheLibraryOnEveryFrame) {
  const testing::ToyWorld toy = testing::MakeToyWorld();
  const BodyReader reader(*toy.character);
  const mjModel* model = toy.character->model();
  const character::DataPtr data(mj_makeData(model));
  BodyState simulated(reader.num_bodies(), reader.num_joints());
  BodyState reference = simulated;

  for (int clip = 0; clip < toy.library->num_clips(); ++clip) {
    for (int f = 0; f < toy.library->clip(clip).num_frames(); ++f) {
      const motion::FrameView frame = toy.library->frame(clip, f);
      SetReferencePose(*toy.character, frame, data.get());
      reader.Read(data.get(), &simulated);
      reader.Read(frame, &reference);
      for (int b = 0; b < reader.num_bodies(); ++b) {
        const auto distance = [&](const auto& member) {
          return (member(simulated)[b] - member(reference)[b]).norm();
        };
        EXPECT_LT(distance([](auto& s) { return s.position; }), 1e-5);
        EXPECT_LT(distance([](auto& s) { return s.linear_velocity; }), 1e-4);
        EXPECT_LT(distance([](auto& s) { return s.angular_velocity; }), 1e-4);
        EXPECT_LT(simulated.rotation[b].angularDistance(reference.rotation[b]),
                  1e-5);
      }
      EXPECT_NEAR(simulated.joint_position[1], reference.joint_position[1],
                  1e-6);
      EXPECT_NEAR(simulated.joint_velocity[3], reference.joint_velocity[3],
                  1e-5);
    }
  }
}

}  // namespace
}  // namespace sinew::world
