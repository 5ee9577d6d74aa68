#include "sim/world/body_state.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numbers>
#include <vector>

#include "sim/world/testing/toy_world.h"
#include "sim/world/tracking_task.h"

namespace sinew::world {
namespace {

using Eigen::AngleAxisd;
using Eigen::Quaterniond;
using Eigen::Vector3d;

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
  BodyReader::Refresh(model, data.get());
  BodyState state(reader.num_bodies(), reader.num_joints());
  reader.Read(model, data.get(), &state);
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
      BodyReader::Refresh(model, data.get());
      reader.Read(model, data.get(), &simulated);
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
