#include "sim/world/tracking_task.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <vector>

#include "common/random/philox.h"
#include "common/testing/allocation_count.h"
#include "common/testing/matchers.h"
#include "sim/world/testing/task_rig.h"
#include "sim/world/testing/toy_world.h"

namespace sinew::world {
namespace {

using ::sinew::testing::StatusIs;
using ::testing::Each;
using ::testing::HasSubstr;
using testing::TaskRig;

// Overwrites everything that a step could find and that no state row holds.
void Scribble(const mjModel* model, mjData* data) {
  std::memset(data->xpos, 0x7f, sizeof(mjtNum) * 3 * model->nbody);
  std::memset(data->xquat, 0x7f, sizeof(mjtNum) * 4 * model->nbody);
  std::memset(data->cvel, 0x7f, sizeof(mjtNum) * 6 * model->nbody);
  std::memset(data->subtree_com, 0x7f, sizeof(mjtNum) * 3 * model->nbody);
  std::memset(data->qacc, 0x7f, sizeof(mjtNum) * model->nv);
  std::memset(data->qfrc_passive, 0x7f, sizeof(mjtNum) * model->nv);
  std::memset(data->qfrc_constraint, 0x7f, sizeof(mjtNum) * model->nv);
  std::memset(data->geom_xpos, 0x7f, sizeof(mjtNum) * 3 * model->ngeom);
}

TEST(TrackingTask, KinematicPlaybackHasFullRewardAndNoErrorOnEveryFrame) {
  TaskRig rig;
  const motion::Library& library = *rig.toy.library;
  motion::ReferenceFrame frame(library);
  for (int clip = 0; clip < library.num_clips(); ++clip) {
    // Looping clips: into the third period.
    const int frames = library.clip(clip).loops() ? 60 : 15;
    rig.episode = {.clip = clip, .start_frame = 0};
    for (int i = 1; i <= frames; ++i) {
      frame.Load(clip, i);
      SetReferencePose(*rig.toy.character, frame.view(), rig.data.get());

      const StepResult result = rig.task->Finish(
          rig.data.get(), ActuationResult(), &rig.episode, rig.work.get());

      EXPECT_NEAR(result.reward, 1, 1e-5) << clip << " frame " << i;
      EXPECT_NEAR(result.mean_body_distance, 0, 1e-5) << clip << " " << i;
      EXPECT_THAT(result.reward_terms, Each(::testing::FloatNear(1, 1e-5)));
      EXPECT_FALSE(result.terminated);
    }
  }
}

TEST(TrackingTask, TheNextFrameIsWhatObservationShowsAndRewardCompares) {
  TaskRig rig;
  rig.Begin(0, 5);
  motion::ReferenceFrame frame(*rig.toy.library);
  frame.Load(0, 6);

  // The difference block starts with the root's offset in the heading frame.
  const std::vector<float> observation = rig.Observe();
  const int self = 13 + 2 * 4 + 3 * 4;
  const double dx = frame.view().root_position[0] - rig.data->qpos[0];
  const double dy = frame.view().root_position[1] - rig.data->qpos[1];
  EXPECT_NEAR(std::hypot(observation[self], observation[self + 1]),
              std::hypot(dx, dy), 1e-5);
  EXPECT_GT(std::hypot(dx, dy), 0.01);

  SetReferencePose(*rig.toy.character, frame.view(), rig.data.get());
  EXPECT_NEAR(rig.task
                  ->Finish(rig.data.get(), ActuationResult(), &rig.episode,
                           rig.work.get())
                  .mean_body_distance,
              0, 1e-5);
}

TEST(TrackingTask, ZeroActionTargetsTheNextReference) {
  TaskRig rig;
  rig.Begin(0, 23);  // the next frame is the first of the next period
  rig.task->Target(rig.data.get(), rig.episode, rig.action,
                   absl::MakeSpan(rig.target), rig.work.get());

  const motion::FrameView first = rig.toy.library->frame(0, 0);
  for (int j = 0; j < 4; ++j) {
    EXPECT_DOUBLE_EQ(rig.target[j], first.joint_position[j]);
  }
}

TEST(TrackingTask, AStandingToySurvivesItsClipAndIsTruncated) {
  TaskRig rig;
  rig.Begin(1, 0);

  StepResult result;
  for (int i = 1; i <= 19; ++i) {
    result = rig.Step();
    EXPECT_FALSE(result.terminated) << i;
    EXPECT_EQ(result.truncated, i == 19) << i;
  }

  EXPECT_TRUE(result.clip_end);
  EXPECT_EQ(rig.episode.step, 19);
  EXPECT_GT(rig.episode.episode_return, 19 * 0.8);
  EXPECT_LT(rig.episode.episode_error, 19 * 0.05);
}

TEST(TrackingTask, AnImpossibleMotionTerminates) {
  TaskRig rig;
  rig.Begin(2, 0);

  int steps = 0;
  StepResult result;
  while (!result.terminated && ++steps < 15) result = rig.Step();

  EXPECT_TRUE(result.terminated);
  EXPECT_FALSE(result.truncated);
  EXPECT_GT(steps, 1);
}

TEST(TrackingTask, TheTimeLimitTruncates) {
  v1::Recipe recipe = testing::ToyRecipe();
  recipe.mutable_task()->set_max_episode_steps(3);
  TaskRig rig(recipe);
  rig.Begin(1, 0);

  EXPECT_FALSE(rig.Step().truncated);
  EXPECT_FALSE(rig.Step().truncated);
  const StepResult last = rig.Step();

  EXPECT_TRUE(last.truncated);
  EXPECT_FALSE(last.clip_end);
}

TEST(TrackingTask, GivesTheSameBytesWhateverLayInTheData) {
  TaskRig clean, scribbled;
  clean.Begin(0, 3);
  scribbled.Begin(0, 3);
  for (int i = 0; i < 12; ++i) {
    for (int j = 0; j < 4; ++j) clean.action[j] = std::sin(i + 0.5F * j);
    scribbled.action = clean.action;
    const std::vector<double> row = scribbled.Row();
    Scribble(scribbled.model, scribbled.data.get());
    scribbled.SetRow(row);
    scribbled.task->Refresh(scribbled.data.get(), scribbled.work.get());

    ASSERT_EQ(clean.Observe(), scribbled.Observe()) << i;
    const StepResult a = clean.Step();
    Scribble(scribbled.model, scribbled.data.get());
    scribbled.SetRow(row);
    const StepResult b = scribbled.Step();

    ASSERT_EQ(clean.Row(), scribbled.Row()) << i;
    EXPECT_EQ(a.reward, b.reward);
    EXPECT_EQ(a.mean_body_distance, b.mean_body_distance);
  }
}

TEST(TrackingTask, RecordedTargetsReplayWithoutAReference) {
  for (bool ramp : {false, true}) {
    v1::Recipe recipe = testing::ToyRecipe();
    recipe.mutable_task()->mutable_action()->set_ramp(ramp);
    recipe.mutable_task()->mutable_action()->set_velocity_feedforward(true);
    recipe.mutable_task()->mutable_action()->set_torque_feedforward(true);
    TaskRig rig(recipe);
    rig.Begin(0, 10);
    const std::vector<double> start = rig.Row();
    const std::vector<double> first_previous = rig.previous;
    std::vector<std::vector<double>> targets, rows;
    for (int i = 0; i < 10; ++i) {
      for (int j = 0; j < 4; ++j) rig.action[j] = std::cos(2.0F * i + j);
      rig.Step();
      targets.push_back(rig.target);
      rows.push_back(rig.Row());
    }

    // The torque law alone, from the first state and the recorded targets.
    const Actuation actuation(*rig.toy.character, 4, ramp);
    const character::DataPtr data(mj_makeData(rig.model));
    mj_setState(rig.model, data.get(), start.data(), mjSTATE_INTEGRATION);
    std::vector<double> previous = first_previous;
    for (size_t i = 0; i < targets.size(); ++i) {
      actuation.Run(previous, targets[i], data.get());
      previous = targets[i];
      std::vector<double> row(rig.task->state_size());
      mj_getState(rig.model, data.get(), row.data(), mjSTATE_INTEGRATION);
      ASSERT_EQ(row, rows[i]) << "ramp " << ramp << " step " << i;
    }
  }
}

TEST(TrackingTask, ResetForgetsEverything) {
  TaskRig rig;
  rig.Begin(0, 3);
  const std::vector<double> row = rig.Row();
  for (int i = 0; i < 3; ++i) rig.Step();

  rig.Begin(0, 3);

  EXPECT_EQ(rig.Row(), row);
}

TEST(TrackingTask, StartNoiseIsKeyedAndMovesJointsOnly) {
  v1::Recipe recipe = testing::ToyRecipe();
  recipe.mutable_task()->mutable_start()->set_joint_position_noise(0.1);
  recipe.mutable_task()->mutable_start()->set_joint_velocity_noise(0.2);
  TaskRig rig(recipe);
  rig.Begin(0, 3);
  const std::vector<double> exact = rig.Row();
  const auto noisy = [&](uint64_t episode) {
    const RandomKey key{.seed = 1,
                        .environment = 2,
                        .episode = episode,
                        .step = 0,
                        .purpose = RandomPurpose::kStartNoise};
    rig.task->Reset(rig.episode, &key, rig.data.get(),
                    absl::MakeSpan(rig.previous), rig.work.get());
    return rig.Row();
  };

  const std::vector<double> first = noisy(7);

  EXPECT_EQ(first, noisy(7));
  EXPECT_NE(first, noisy(8));
  EXPECT_NE(first, exact);
  for (int i = 0; i < 1 + 7; ++i) EXPECT_EQ(first[i], exact[i]);  // time, root
}

TEST(TrackingTask, SelfContactSeesSolesOnTheFloor) {
  v1::Recipe recipe = testing::ToyRecipe();
  auto* observation = recipe.mutable_task()->mutable_observation();
  observation->clear_blocks();
  observation->add_blocks(v1::Observation::BLOCK_SELF_CONTACT);
  observation->add_blocks(v1::Observation::BLOCK_REFERENCE_CONTACT);
  TaskRig rig(recipe);

  rig.Begin(1, 0);  // standing
  rig.Step();
  EXPECT_THAT(rig.Observe(), ::testing::ElementsAre(1, 1, 1, 1));
  rig.Begin(2, 0);  // in the air
  EXPECT_THAT(rig.Observe(), ::testing::ElementsAre(0, 0, 0, 0));
}

TEST(TrackingTask, StepsDoNotAllocate) {
  v1::Recipe recipe = testing::ToyRecipe();
  auto* blocks = recipe.mutable_task()->mutable_observation();
  blocks->clear_blocks();
  for (int block = 1; block <= 5; ++block) {
    blocks->add_blocks(static_cast<v1::Observation::Block>(block));
  }
  blocks->add_blocks(v1::Observation::BLOCK_SELF_BODIES);
  recipe.mutable_task()->mutable_start()->set_joint_position_noise(0.1);
  TaskRig rig(recipe);
  const RandomKey key;
  const int64_t before = sinew::testing::AllocationCount();

  for (int i = 0; i < 5; ++i) {
    rig.episode = {.clip = i % 3};
    rig.task->Reset(rig.episode, &key, rig.data.get(),
                    absl::MakeSpan(rig.previous), rig.work.get());
    for (int k = 0; k < 4; ++k) {
      rig.Observe();
      rig.Step();
    }
  }

  EXPECT_EQ(sinew::testing::AllocationCount() - before, 0);
}

TEST(TrackingTask, ADivergedStepIsAFailureWithoutNumbers) {
  TaskRig rig;
  rig.Begin(0, 0);
  rig.data->qvel[2] = 1e6;

  const StepResult result = rig.Step();

  EXPECT_TRUE(result.diverged);
  EXPECT_TRUE(result.terminated);
  EXPECT_FALSE(result.truncated);
  EXPECT_EQ(result.reward, 0);
  EXPECT_EQ(rig.episode.step, 1);
  EXPECT_EQ(rig.episode.episode_return, 0);
}

TEST(TrackingTask, NamesItsObservation) {
  TaskRig rig;

  const std::vector<std::string> names = rig.task->ObservationNames();

  ASSERT_EQ(static_cast<int>(names.size()), rig.task->observation_width());
  EXPECT_EQ(names[13], "self/joint_position/hip_fl");
  EXPECT_EQ(names[14], "self/joint_position/hip_br");
}

TEST(TrackingTask, RefusesWhatDoesNotFit) {
  const testing::ToyWorld toy = testing::MakeToyWorld();
  const auto create = [&](const v1::Recipe& recipe) {
    return TrackingTask::Create(recipe, *toy.character, *toy.library).status();
  };
  const auto refused = [](const char* message) {
    return StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr(message));
  };

  v1::Recipe recipe = toy.recipe;
  recipe.mutable_physics()->set_control_hz(50);
  EXPECT_THAT(create(recipe), refused("physics.physics_hz: expected a multiple "
                                      "of control_hz 50, found 120"));
  recipe.mutable_physics()->set_control_hz(60);
  EXPECT_THAT(create(recipe),
              refused("motion library field frames_per_second: expected 60 "
                      "(physics.control_hz), found 30"));
  recipe = toy.recipe;
  recipe.mutable_physics()->set_physics_hz(240);
  EXPECT_THAT(create(recipe), refused("expected time step 0.00416667 s"));
  recipe = toy.recipe;
  recipe.mutable_task()->mutable_observation()->add_frames_ahead(0);
  EXPECT_THAT(create(recipe), refused("frames_ahead"));
}

}  // namespace
}  // namespace sinew::world
