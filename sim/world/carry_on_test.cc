// Episodes of the tracking task that begin where the one before left the body.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "common/config/recipe.h"
#include "common/testing/allocation_count.h"
#include "sim/motion/rotation.h"
#include "sim/world/body_state.h"
#include "sim/world/nearest_frame.h"
#include "sim/world/testing/task_rig.h"

namespace sinew::world {
namespace {

using testing::TaskRig;

constexpr int kTurn = 0, kSway = 1;

v1::Recipe CarryingRecipe() {
  v1::Recipe recipe = testing::ToyRecipe();
  recipe.mutable_distillation()->set_prior_share(0.5);
  return WithDefaults(recipe);
}

// On a frame, then elsewhere on the floor and turned by this yaw.
void BeginElsewhere(TaskRig& rig, int clip, int frame, double yaw) {
  rig.Begin(
      clip, frame,
      {.kind = v1::START_KIND_FAR, .offset_x = 5, .offset_y = -3, .turn = yaw});
  rig.episode = {.episode = 8};
}

bool CarryOn(TaskRig& rig) {
  const NearestFrames frames(rig.toy.recipe.task().start(), *rig.toy.library,
                             BodyReader(rig.task->character()));
  return rig.task->CarryOn(frames, /*max_distance=*/0.1, rig.data.get(),
                           &rig.episode, rig.work.get());
}

double RootHeight(const TaskRig& rig) {
  return rig.data->qpos[rig.task->character().root_qpos_address() + 2];
}

TEST(CarryOn, PutsTheBodyOntoTheFrameThatIsNearest) {
  TaskRig rig(CarryingRecipe());
  rig.Begin(kTurn, 9);
  const std::vector<double> there = rig.Row();
  BeginElsewhere(rig, kTurn, 9, 2.2);
  ASSERT_NE(rig.Row(), there);

  ASSERT_TRUE(CarryOn(rig));

  EXPECT_EQ(rig.episode.episode, 8);
  EXPECT_EQ(rig.episode.clip, kTurn);
  EXPECT_EQ(rig.episode.start_frame, 9);
  EXPECT_EQ(rig.episode.step, 0);
  EXPECT_EQ(rig.episode.start_kind, v1::START_KIND_CARRIED);
  const std::vector<double> row = rig.Row();
  for (size_t i = 0; i < row.size(); ++i) {
    EXPECT_NEAR(row[i], there[i], 1e-9) << i;
  }
}

TEST(CarryOn, LeavesPoseHeightAndMotionOfTheBodyAsTheyAre) {
  TaskRig rig(CarryingRecipe());
  BeginElsewhere(rig, kSway, 2, -1.1);
  const auto& joints = rig.task->character().joints();
  rig.data->qpos[joints[0].qpos_address] += 0.05;
  rig.data->qvel[joints[1].dof_address] -= 0.2;
  const int root = rig.task->character().root_dof_address();
  rig.data->qvel[root] = 0.1;
  rig.data->qvel[root + 5] = 0.3;
  rig.task->Refresh(rig.data.get(), rig.work.get());
  const BodyState before = rig.work->body;
  const double height = RootHeight(rig);
  const double time = rig.data->time = 1.5;

  ASSERT_TRUE(CarryOn(rig));

  const BodyState& after = rig.work->body;
  EXPECT_EQ(after.joint_position, before.joint_position);
  EXPECT_EQ(after.joint_velocity, before.joint_velocity);
  EXPECT_EQ(RootHeight(rig), height);
  EXPECT_EQ(rig.data->time, time);
  // Seen from its own heading nothing has changed.
  const Eigen::Quaterniond back_before =
      Heading(before.rotation[0]).conjugate();
  const Eigen::Quaterniond back_after = Heading(after.rotation[0]).conjugate();
  const auto expect_same = [&](const Eigen::Vector3d& now,
                               const Eigen::Vector3d& then) {
    EXPECT_LT((back_after * now - back_before * then).norm(), 1e-9);
  };
  for (size_t b = 0; b < after.position.size(); ++b) {
    expect_same(after.position[b] - after.position[0],
                before.position[b] - before.position[0]);
    expect_same(after.linear_velocity[b], before.linear_velocity[b]);
    expect_same(after.angular_velocity[b], before.angular_velocity[b]);
  }
  // Root and heading are the frame's.
  const auto frame =
      rig.toy.library->frame(rig.episode.clip, rig.episode.start_frame);
  EXPECT_NEAR(after.position[0].x(), frame.root_position[0], 1e-6);
  EXPECT_NEAR(after.position[0].y(), frame.root_position[1], 1e-6);
  EXPECT_LT(
      Heading(after.rotation[0])
          .angularDistance(Heading(motion::FromWxyz(frame.root_rotation))),
      1e-6);
}

TEST(CarryOn, ABodyThatIsFarFromAllFramesDoesNot) {
  TaskRig rig(CarryingRecipe());
  BeginElsewhere(rig, kSway, 2, 0);
  const int height = rig.task->character().root_qpos_address() + 2;
  rig.data->qpos[height] += 0.05;
  EXPECT_TRUE(CarryOn(rig));

  BeginElsewhere(rig, kSway, 2, 0);
  rig.data->qpos[height] -= 0.15;
  EXPECT_FALSE(CarryOn(rig));
  EXPECT_EQ(rig.episode.start_kind, v1::START_KIND_REFERENCE);
}

TEST(CarryOn, DoesNotAllocateAgain) {
  TaskRig rig(CarryingRecipe());
  const NearestFrames frames(rig.toy.recipe.task().start(), *rig.toy.library,
                             BodyReader(rig.task->character()));
  const auto carry_on = [&] {
    BeginElsewhere(rig, kTurn, 9, 1);
    const int64_t before = sinew::testing::AllocationCount();
    EXPECT_TRUE(rig.task->CarryOn(frames, /*max_distance=*/0.1, rig.data.get(),
                                  &rig.episode, rig.work.get()));
    return sinew::testing::AllocationCount() - before;
  };
  carry_on();

  EXPECT_EQ(carry_on(), 0);
}

}  // namespace
}  // namespace sinew::world
