// The tracking task with recovery starts.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "common/config/recipe.h"
#include "common/testing/allocation_count.h"
#include "sim/motion/rotation.h"
#include "sim/world/body_state.h"
#include "sim/world/get_up_frames.h"
#include "sim/world/nearest_frame.h"
#include "sim/world/testing/task_rig.h"

namespace sinew::world {
namespace {

using testing::TaskRig;

v1::Recipe RecoveryRecipe() {
  v1::Recipe recipe = testing::ToyRecipe();
  v1::Recovery* recovery = recipe.mutable_task()->mutable_recovery();
  recovery->set_fallen_share(0.5);
  recovery->set_far_share(0.25);
  recovery->set_fallen_states(2);
  return WithDefaults(recipe);
}

BodyStart Far(double offset_x, int recovery_steps) {
  return {.kind = v1::START_KIND_FAR,
          .offset_x = offset_x,
          .recovery_steps = recovery_steps};
}

TEST(RecoveryTask, IsAsEverWithoutRecovery) {
  TaskRig rig;
  const BodyStart start = rig.task->DrawStart({.seed = 1});
  rig.Begin(0, 5, start);
  const std::vector<double> row = rig.Row();
  const std::vector<double> previous = rig.previous;
  rig.task->Reset(rig.episode, nullptr, rig.data.get(),
                  absl::MakeSpan(rig.previous), rig.work.get());

  EXPECT_EQ(start.kind, v1::START_KIND_REFERENCE);
  EXPECT_EQ(rig.Row(), row);
  EXPECT_EQ(rig.previous, previous);
  EXPECT_EQ(rig.episode.goal_distance, 0);
}

TEST(RecoveryTask, ReferenceStandsAndNothingEndsTheEpisodeWhileItRecovers) {
  TaskRig rig(RecoveryRecipe());
  rig.Begin(1, 3, Far(2, 5));

  for (int i = 1; i <= 5; ++i) {
    const StepResult result = rig.Step();
    EXPECT_FALSE(result.terminated) << i;
    EXPECT_FALSE(result.truncated) << i;
    EXPECT_EQ(CurrentFrame(rig.episode), 3) << i;
    EXPECT_EQ(rig.episode.recovery_steps_left, 5 - i);
    EXPECT_EQ(rig.episode.step, i);
  }
  EXPECT_FALSE(rig.Step().terminated);  // the step in which it may answer
  EXPECT_EQ(CurrentFrame(rig.episode), 4);
  EXPECT_TRUE(rig.Step().terminated);  // two metres are too many
}

TEST(RecoveryTask, FrozenStepsCountNotForTheTimeLimit) {
  v1::Recipe recipe = RecoveryRecipe();
  recipe.mutable_task()->set_max_episode_steps(3);
  TaskRig rig(recipe);
  rig.Begin(1, 0, {.recovery_steps = 4});

  for (int i = 1; i <= 6; ++i) EXPECT_FALSE(rig.Step().truncated) << i;
  const StepResult last = rig.Step();

  EXPECT_TRUE(last.truncated);
  EXPECT_FALSE(last.clip_end);
}

TEST(RecoveryTask, FarStartsHaveTheReferencesPoseElsewhereAndTurned) {
  TaskRig on_reference(RecoveryRecipe()), far(RecoveryRecipe());
  on_reference.Begin(0, 7);
  far.Begin(0, 7,
            {.kind = v1::START_KIND_FAR,
             .offset_x = 3,
             .offset_y = -4,
             .turn = 0.5,
             .recovery_steps = 9});

  const double* from = on_reference.data->qpos;
  const double* to = far.data->qpos;
  EXPECT_NEAR(to[0] - from[0], 3, 1e-12);
  EXPECT_NEAR(to[1] - from[1], -4, 1e-12);
  EXPECT_EQ(to[2], from[2]);
  for (int i = 7; i < 11; ++i) EXPECT_EQ(to[i], from[i]);
  const Eigen::Quaterniond between =
      motion::FromWxyz(to + 3) * motion::FromWxyz(from + 3).conjugate();
  EXPECT_NEAR(between.w(), std::cos(0.25), 1e-9);
  EXPECT_NEAR(between.z(), std::sin(0.25), 1e-9);
  const double* v = on_reference.data->qvel;
  EXPECT_NEAR(far.data->qvel[0], std::cos(0.5) * v[0] - std::sin(0.5) * v[1],
              1e-9);
  EXPECT_NEAR(far.data->qvel[1], std::sin(0.5) * v[0] + std::cos(0.5) * v[1],
              1e-9);
  for (int i = 2; i < 10; ++i) EXPECT_EQ(far.data->qvel[i], v[i]);
  EXPECT_EQ(far.previous, on_reference.previous);
}

TEST(RecoveryTask, FallenStartsLieBelowTheReferencesRootAtRest) {
  TaskRig rig(RecoveryRecipe());
  rig.Begin(
      1, 2,
      {.kind = v1::START_KIND_FALLEN, .fallen_state = 1, .recovery_steps = 9});

  const motion::FrameView reference = rig.toy.library->frame(1, 2);
  const absl::Span<const double> fallen = rig.fallen->qpos(1);
  EXPECT_DOUBLE_EQ(rig.data->qpos[0], reference.root_position[0]);
  EXPECT_DOUBLE_EQ(rig.data->qpos[1], reference.root_position[1]);
  EXPECT_EQ(rig.data->qpos[2], fallen[2]);
  for (int i = 7; i < 11; ++i) EXPECT_EQ(rig.data->qpos[i], fallen[i]);
  for (int i = 0; i < 10; ++i) EXPECT_EQ(rig.data->qvel[i], 0);
  for (int j = 0; j < 4; ++j) {
    EXPECT_EQ(rig.previous[j],
              rig.data->qpos[rig.toy.character->joints()[j].qpos_address]);
  }
  EXPECT_NEAR(
      rig.episode.goal_distance,
      std::abs(fallen[2] - rig.toy.library->frame(1, 3).root_position[2]),
      1e-5);
}

v1::Recipe GetUpRecipe() {
  v1::Recipe recipe = RecoveryRecipe();
  v1::Recovery* recovery = recipe.mutable_task()->mutable_recovery();
  recovery->set_get_up_share(0.25);
  recovery->set_get_up_steps(4);
  return recipe;
}

TEST(RecoveryTask, GetUpsHaveAFallenBodyOnTheNearestOfTheirFrames) {
  TaskRig rig(GetUpRecipe(), testing::ToyClips::kWithGetUp);
  ASSERT_EQ(rig.task->num_get_up_frames(), 7);
  rig.Begin(
      0, 5,
      {.kind = v1::START_KIND_GET_UP, .fallen_state = 1, .recovery_steps = 4});

  EXPECT_EQ(rig.episode.start_kind, v1::START_KIND_GET_UP);
  EXPECT_EQ(rig.episode.clip, 1);
  EXPECT_LT(rig.episode.start_frame, 7);
  const motion::FrameView frame =
      rig.toy.library->frame(1, rig.episode.start_frame);
  const absl::Span<const double> fallen = rig.fallen->qpos(1);
  EXPECT_DOUBLE_EQ(rig.data->qpos[0], frame.root_position[0]);
  EXPECT_DOUBLE_EQ(rig.data->qpos[1], frame.root_position[1]);
  EXPECT_EQ(rig.data->qpos[2], fallen[2]);
  EXPECT_TRUE(
      Heading(motion::FromWxyz(rig.data->qpos + 3))
          .isApprox(Heading(motion::FromWxyz(frame.root_rotation)), 1e-5));
  for (int i = 7; i < 11; ++i) EXPECT_EQ(rig.data->qpos[i], fallen[i]);
  for (int i = 0; i < 10; ++i) EXPECT_EQ(rig.data->qvel[i], 0);
  for (int j = 0; j < 4; ++j) {
    EXPECT_EQ(rig.previous[j],
              rig.data->qpos[rig.toy.character->joints()[j].qpos_address]);
  }
  const BodyReader reader(*rig.toy.character);
  const NearestFrames nearest(
      GetUpFrames({}, *rig.toy.character, *rig.toy.library), *rig.toy.library,
      reader);
  std::vector<float> scratch(nearest.width());
  const auto found = nearest.Find(rig.work->body, absl::MakeSpan(scratch));
  ASSERT_TRUE(found.has_value());
  EXPECT_EQ(rig.episode.start_frame, found->frame);
  // From the frame after it, which stands, and then goes on.
  const int first = rig.episode.start_frame;
  EXPECT_NEAR(
      rig.episode.goal_distance,
      (rig.work->body.position[0] -
       Eigen::Vector3d(rig.toy.library->frame(1, first + 1).root_position[0],
                       rig.toy.library->frame(1, first + 1).root_position[1],
                       rig.toy.library->frame(1, first + 1).root_position[2]))
          .norm(),
      1e-5);
  for (int i = 0; i < 4; ++i) {
    EXPECT_FALSE(rig.Step().terminated) << i;
    EXPECT_EQ(CurrentFrame(rig.episode), first);
  }
  rig.Step();
  EXPECT_EQ(CurrentFrame(rig.episode), first + 1);
}

TEST(RecoveryTask, RewardIsTheGainInDistanceWhereTheReferenceIsNotNear) {
  TaskRig rig(RecoveryRecipe());
  rig.Begin(1, 3, Far(2, 5));
  const double before = rig.episode.goal_distance;
  EXPECT_NEAR(before, 2, 1e-5);
  rig.data->qvel[0] = -1.5;  // towards it

  const StepResult result = rig.Step();

  const double gain = before - rig.episode.goal_distance;
  EXPECT_GT(gain, 0.01);
  EXPECT_FLOAT_EQ(result.reward, static_cast<float>(9 * gain));
}

TEST(RecoveryTask, RewardHasHalfTheTrackingWhereTheReferenceIsNear) {
  TaskRig rig(RecoveryRecipe());
  rig.Begin(1, 3);
  const double before = rig.episode.goal_distance;

  const StepResult result = rig.Step();

  const float* terms = result.reward_terms;
  const double tracking =
      0.5 * terms[0] + 0.3 * terms[1] + 0.1 * terms[2] + 0.1 * terms[3];
  EXPECT_GT(tracking, 0.5);
  EXPECT_NEAR(result.reward,
              9 * (before - rig.episode.goal_distance) + 0.5 * tracking, 1e-5);
}

TEST(RecoveryTask, AReferenceOutOfSightIsADirectionAndActsOnNothing) {
  TaskRig rig(RecoveryRecipe());
  rig.Begin(1, 3, Far(10, 5));

  const std::vector<float> observation = rig.Observe();
  const std::vector<std::string> names = rig.task->ObservationNames();
  double squares = 0;
  for (size_t i = 0; i < names.size(); ++i) {
    if (names[i].rfind("reference+1/", 0) != 0) continue;
    if (names[i].find("/root_position/") != std::string::npos) {
      squares += observation[i] * observation[i];
    } else {
      // The identity's first two columns; else no difference.
      const bool one = names[i] == "reference+1/root_rotation/00" ||
                       names[i] == "reference+1/root_rotation/11";
      EXPECT_NEAR(observation[i], one ? 1 : 0, 1e-6) << names[i];
    }
  }
  EXPECT_NEAR(std::sqrt(squares), 3, 1e-5);

  rig.Step();
  for (int j = 0; j < 4; ++j) {
    EXPECT_EQ(rig.target[j], rig.toy.character->joints()[j].default_position);
  }
}

TEST(RecoveryTask, ContinuesFromItsStateAlone) {
  TaskRig whole(RecoveryRecipe()), parts(RecoveryRecipe());
  const BodyStart start = {
      .kind = v1::START_KIND_FALLEN, .turn = 1, .recovery_steps = 3};
  whole.Begin(0, 5, start);
  parts.Begin(0, 5, start);
  for (int i = 0; i < 8; ++i) {
    const std::vector<double> row = parts.Row();
    const Episode episode = parts.episode;
    const std::vector<double> previous = parts.previous;
    parts.Begin(2, 1);  // other work in between
    parts.Step();
    parts.SetRow(row);
    parts.episode = episode;
    parts.previous = previous;
    parts.task->Refresh(parts.data.get(), parts.work.get());

    ASSERT_EQ(whole.Observe(), parts.Observe()) << i;
    const StepResult one = whole.Step();
    ASSERT_EQ(one.reward, parts.Step().reward) << i;
    ASSERT_EQ(whole.Row(), parts.Row()) << i;
  }
}

TEST(RecoveryTask, StepsAndStartsDoNotAllocate) {
  TaskRig rig(RecoveryRecipe(), testing::ToyClips::kWithGetUp);
  const BodyStart starts[] = {
      Far(10, 2),
      {.kind = v1::START_KIND_FALLEN, .recovery_steps = 2},
      {.kind = v1::START_KIND_GET_UP, .recovery_steps = 2},
      {}};
  const int64_t before = sinew::testing::AllocationCount();

  for (const BodyStart& start : starts) {
    rig.Begin(1, 0, start);
    for (int i = 0; i < 4; ++i) {
      rig.Observe();
      rig.Step();
    }
  }

  EXPECT_EQ(sinew::testing::AllocationCount() - before, 0);
}

// Both laws lose sight of the reference together.
TEST(RecoveryTask, BasesOfAReferenceOutOfSightAreTheDefaultPose) {
  v1::Recipe recipe = RecoveryRecipe();
  recipe.mutable_distillation()->set_learning_rate(1e-3);
  recipe.mutable_task()->mutable_action()->set_placement(
      v1::Action::PLACEMENT_AROUND_CURRENT);
  TaskRig rig(WithDefaults(recipe));
  std::vector<double> base(4), teacher_base(4);
  const auto bases = [&] {
    rig.task->Bases(rig.data.get(), rig.episode, absl::MakeSpan(base),
                    absl::MakeSpan(teacher_base), rig.work.get());
  };

  rig.Begin(0, 7,
            {.kind = v1::START_KIND_FAR, .offset_x = 50, .recovery_steps = 9});
  bases();
  for (int j = 0; j < 4; ++j) {
    const auto& joint = rig.toy.character->joints()[j];
    EXPECT_EQ(base[j], rig.data->qpos[joint.qpos_address]);
    EXPECT_EQ(teacher_base[j], joint.default_position);
  }
  std::vector<double> target(4);
  rig.task->TeacherTarget(rig.data.get(), rig.episode, rig.action,
                          absl::MakeSpan(target), rig.work.get());
  EXPECT_EQ(target, teacher_base);

  rig.Begin(0, 7);
  bases();
  const motion::FrameView next = rig.toy.library->frame(0, 8);
  for (int j = 0; j < 4; ++j) {
    EXPECT_EQ(teacher_base[j], next.joint_position[j]);
  }
}

}  // namespace
}  // namespace sinew::world
