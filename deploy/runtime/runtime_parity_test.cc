// What the runtime computes from plain numbers is what an actor computes from
// its simulation, bit for bit.
#include <mujoco/mujoco.h>

#include <Eigen/Geometry>
#include <cmath>
#include <memory>
#include <vector>

#include "common/config/recipe.h"
#include "common/policy/executor.h"
#include "common/testing/matchers.h"
#include "deploy/runtime/pose.h"
#include "deploy/runtime/runtime.h"
#include "deploy/runtime/simulation.h"
#include "deploy/runtime/testing/runtime_rig.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "sim/character/model_ptr.h"
#include "sim/world/fallen_states.h"
#include "sim/world/tracking_task.h"

namespace sinew::runtime {
namespace {

using ::sinew::testing::IsOk;
using testing::RuntimeRig;

// An actor's step, written out with the code that actors use.
class Actor {
 public:
  explicit Actor(const RuntimeRig& rig,
                 const world::FallenStates* fallen = nullptr)
      : task_(*world::TrackingTask::Create(rig.toy.recipe, *rig.toy.character,
                                           *rig.toy.library, fallen)),
        data_(mj_makeData(rig.toy.character->model())),
        work_(task_->MakeWorkspace()),
        executor_(*policy::Executor::Create(
            *policy::PackWeights(rig.content.graph, "policy",
                                 rig.content.weights),
            /*max_batch=*/8)),
        previous(task_->action_width()),
        target(task_->action_width()) {}

  void Begin(int clip, int frame) {
    episode_ = {.clip = clip, .start_frame = frame};
    task_->Reset(episode_, nullptr, data_.get(), absl::MakeSpan(previous),
                 work_.get());
  }
  // In a fallen state, on a get-up.
  void BeginFallen(int state, int stand) {
    episode_ = {};
    task_->Begin({.kind = v1::START_KIND_GET_UP,
                  .fallen_state = state,
                  .recovery_steps = stand},
                 nullptr, data_.get(), &episode_, absl::MakeSpan(previous),
                 work_.get());
  }
  const world::Episode& episode() const { return episode_; }
  void Act() {
    task_->Refresh(data_.get(), work_.get());
    const absl::Span<float> input =
        executor_->input(executor_->input_index("observation"));
    task_->Observe(data_.get(), episode_, previous,
                   input.first(task_->observation_width()), work_.get());
    executor_->Run(1);
    observation.assign(input.begin(),
                       input.begin() + task_->observation_width());
    task_->Target(data_.get(), episode_,
                  executor_->tap(executor_->tap_index("action"))
                      .first(task_->action_width()),
                  absl::MakeSpan(target), work_.get());
  }
  world::StepResult Step() {
    return task_->Step(data_.get(), target, &episode_, absl::MakeSpan(previous),
                       work_.get());
  }
  const mjData& data() const { return *data_; }
  // Moves the body, m.
  void MoveBy(double x) { data_->qpos[0] += x; }

 private:
  const std::unique_ptr<const world::TrackingTask> task_;
  const character::DataPtr data_;
  const std::unique_ptr<world::TrackingTask::Workspace> work_;
  const std::unique_ptr<policy::Executor> executor_;
  world::Episode episode_;

 public:
  std::vector<double> previous, target;
  std::vector<float> observation;
};

// Runtime and actor begin at a clip's frame, the body moved by `away` m, and
// see and want the same at each of `steps` steps.
void ExpectTheSame(RuntimeRig& rig, Actor& actor, int clip, int frame,
                   double away, int steps) {
  Runtime& runtime = *rig.runtime;
  PoseBuffer pose(4);
  ASSERT_THAT(runtime.Play(rig.toy.library->clip(clip).name(), frame / 30.0,
                           Runtime::Align::kNone),
              IsOk());
  actor.Begin(clip, frame);
  actor.MoveBy(away);
  pose.Read(*rig.toy.character, actor.data());
  ASSERT_THAT(runtime.Reset(pose.pose(), nullptr), IsOk());
  for (int step = 0; step < steps; ++step) {
    SCOPED_TRACE(step);
    actor.Act();
    pose.Read(*rig.toy.character, actor.data());

    ASSERT_THAT(runtime.Step(pose.pose(), absl::MakeSpan(rig.target)), IsOk());

    ASSERT_EQ(std::vector<float>(runtime.observation().begin(),
                                 runtime.observation().end()),
              actor.observation);
    ASSERT_EQ(rig.target, actor.target);
    if (actor.Step().diverged) break;
  }
}

TEST(RuntimeParity, FollowsALibraryBitForBitAsAnActorDoes) {
  RuntimeRig rig;
  ASSERT_THAT(rig.runtime->LoadLibrary(rig.library()), IsOk());
  Actor actor(rig);
  for (const int clip : {0, 1, 2}) {
    SCOPED_TRACE(clip);
    ExpectTheSame(rig, actor, clip, /*frame=*/3 * clip + 1, /*away=*/0,
                  /*steps=*/40);
  }
}

// Recovery on, own state and goals in body space, drives of their own.
void UseVariants(v1::Task& task) {
  task.mutable_observation()->add_blocks(v1::Observation::BLOCK_SELF_BODIES);
  task.mutable_observation()->add_blocks(
      v1::Observation::BLOCK_REFERENCE_KEYPOINTS);
  task.mutable_observation()->add_blocks(
      v1::Observation::BLOCK_REFERENCE_BODIES);
  task.mutable_recovery()->set_far_share(0.5);
  task.mutable_actuator_model()->add_drives();
  v1::Recipe recipe;
  *recipe.mutable_task() = task;
  task = WithDefaults(recipe).task();
}

TEST(RuntimeParity, FollowsAReferenceOutOfSightAsAnActorDoes) {
  RuntimeRig rig(UseVariants);
  ASSERT_THAT(rig.runtime->LoadLibrary(rig.library()), IsOk());
  Actor actor(rig);
  for (const double away : {0.0, 6.0}) {
    SCOPED_TRACE(away);
    ExpectTheSame(rig, actor, /*clip=*/0, /*frame=*/3, away, /*steps=*/10);
  }
}

// Elsewhere on the floor, so not bit for bit. The runtime's previous target
// goes on from before; the actor's is where the joints are.
TEST(RuntimeParity, ShowsAFallenBodyTheGetUpThatAnActorIsShown) {
  RuntimeRig rig([](v1::Task&) {}, world::testing::ToyClips::kWithGetUp);
  ASSERT_THAT(rig.runtime->LoadLibrary(rig.library()), IsOk());
  const auto fallen = world::FallenStates::MakeForEvaluation(
      *rig.toy.character, rig.toy.recipe, /*count=*/3);
  ASSERT_THAT(fallen, IsOk());
  Actor actor(rig, &*fallen);
  PoseBuffer pose(4);
  for (int state = 0; state < 3; ++state) {
    SCOPED_TRACE(state);
    actor.BeginFallen(state, /*stand=*/4);
    for (int step = 0; step < 10; ++step) {
      actor.Act();
      pose.Read(*rig.toy.character, actor.data());
      pose.Move(Eigen::Quaterniond(std::cos(1), 0, 0, std::sin(1)),
                Eigen::Vector3d(5, -3, 0));
      Pose body = pose.pose();
      body.previous_target = actor.previous.data();
      if (step == 0) {
        ASSERT_THAT(rig.runtime->PlayNearest(body, Runtime::Among::kGetUps, 4),
                    IsOk());
        ASSERT_THAT(rig.runtime->Reset(body, nullptr), IsOk());
        EXPECT_EQ(rig.runtime->clip_name(), "sway");
      }
      EXPECT_NEAR(rig.runtime->clip_seconds() * 30,
                  world::CurrentFrame(actor.episode()), 1e-6);

      ASSERT_THAT(rig.runtime->Step(body, absl::MakeSpan(rig.target)), IsOk());

      ASSERT_EQ(rig.runtime->observation().size(), actor.observation.size());
      for (size_t i = 0; i < actor.observation.size(); ++i) {
        ASSERT_NEAR(rig.runtime->observation()[i], actor.observation[i], 1e-4)
            << i;
      }
      for (int j = 0; j < 4; ++j) {
        EXPECT_NEAR(rig.target[j], actor.target[j], 1e-3) << j;
      }
      if (actor.Step().diverged) break;
    }
  }
}

TEST(RuntimeParity, MovesTheBodyByTheDrivesOfItsBundle) {
  RuntimeRig rig(UseVariants);
  ASSERT_THAT(rig.runtime->LoadLibrary(rig.library()), IsOk());
  ASSERT_THAT(rig.runtime->Play("sway", 0, Runtime::Align::kNone), IsOk());
  Simulation body(*rig.runtime);
  ASSERT_THAT(body.Start(*rig.runtime), IsOk());
  Actor actor(rig);
  actor.Begin(1, 0);
  for (int step = 0; step < 5; ++step) {
    actor.Act();
    ASSERT_THAT(rig.runtime->Step(body.pose(), body.target()), IsOk());

    actor.Step();
    ASSERT_THAT(body.Step(), IsOk());

    for (int i = 0; i < rig.toy.character->model()->nq; ++i) {
      EXPECT_NEAR(body.data().qpos[i], actor.data().qpos[i], 1e-6)
          << step << " " << i;
    }
  }
}

}  // namespace
}  // namespace sinew::runtime
