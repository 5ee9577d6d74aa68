// What the runtime computes from plain numbers is what an actor computes from
// its simulation, bit for bit.
#include "deploy/runtime/runtime.h"

#include <mujoco/mujoco.h>

#include <cmath>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "common/config/recipe.h"
#include "common/files.h"
#include "common/policy/executor.h"
#include "common/testing/matchers.h"
#include "deploy/bundle/bundle.h"
#include "deploy/bundle/testing/toy_bundle.h"
#include "deploy/runtime/pose.h"
#include "deploy/runtime/simulation.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "sim/character/model_ptr.h"
#include "sim/world/testing/toy_world.h"
#include "sim/world/tracking_task.h"

namespace sinew::runtime {
namespace {

using ::sinew::testing::IsOk;
using ::sinew::testing::StatusIs;
using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

// A toy bundle with every block of an observation, its library, its task.
struct Rig {
  explicit Rig(const std::function<void(v1::Task&)>& edit = [](v1::Task&) {}) {
    v1::Recipe recipe = world::testing::ToyRecipe();
    v1::Observation& observation =
        *recipe.mutable_task()->mutable_observation();
    observation.clear_blocks();
    for (int block = 1; block <= 5; ++block) {
      observation.add_blocks(static_cast<v1::Observation::Block>(block));
    }
    observation.clear_frames_ahead();
    observation.add_frames_ahead(2);
    observation.add_frames_ahead(7);
    recipe.mutable_task()->mutable_action()->set_velocity_feedforward(true);
    edit(*recipe.mutable_task());
    toy = world::testing::MakeToyWorld(recipe);
    content = bundle::testing::ToyContent(toy);
    const std::string directory = JoinPath(toy.folder, "bundle");
    EXPECT_THAT(bundle::WriteBundle(content, directory), IsOk());
    auto opened = Runtime::Open(directory);
    EXPECT_THAT(opened, IsOk());
    runtime = *std::move(opened);
    task =
        *world::TrackingTask::Create(toy.recipe, *toy.character, *toy.library);
    target.resize(4);
  }
  std::string library() const { return JoinPath(toy.folder, "library"); }

  world::testing::ToyWorld toy;
  bundle::BundleContent content;
  std::unique_ptr<Runtime> runtime;
  std::unique_ptr<world::TrackingTask> task;
  std::vector<double> target;
};

// An actor's step, written out with the code that actors use.
class Actor {
 public:
  explicit Actor(const Rig& rig)
      : task_(*rig.task),
        data_(mj_makeData(rig.toy.character->model())),
        work_(task_.MakeWorkspace()),
        executor_(*policy::Executor::Create(
            *policy::PackWeights(rig.content.graph, "policy",
                                 rig.content.weights),
            /*max_batch=*/8)),
        previous(task_.action_width()),
        target(task_.action_width()) {}

  void Begin(int clip, int frame) {
    episode_ = {.clip = clip, .start_frame = frame};
    task_.Reset(episode_, nullptr, data_.get(), absl::MakeSpan(previous),
                work_.get());
  }
  void Act() {
    task_.Refresh(data_.get(), work_.get());
    const absl::Span<float> input =
        executor_->input(executor_->input_index("observation"));
    task_.Observe(data_.get(), episode_, previous,
                  input.first(task_.observation_width()), work_.get());
    executor_->Run(1);
    observation.assign(input.begin(),
                       input.begin() + task_.observation_width());
    task_.Target(data_.get(), episode_,
                 executor_->tap(executor_->tap_index("action"))
                     .first(task_.action_width()),
                 absl::MakeSpan(target), work_.get());
  }
  world::StepResult Step() {
    return task_.Step(data_.get(), target, &episode_, absl::MakeSpan(previous),
                      work_.get());
  }
  const mjData& data() const { return *data_; }
  // Moves the body, m.
  void MoveBy(double x) { data_->qpos[0] += x; }

 private:
  const world::TrackingTask& task_;
  const character::DataPtr data_;
  const std::unique_ptr<world::TrackingTask::Workspace> work_;
  const std::unique_ptr<policy::Executor> executor_;
  world::Episode episode_;

 public:
  std::vector<double> previous, target;
  std::vector<float> observation;
};

TEST(Runtime, FollowsALibraryBitForBitAsAnActorDoes) {
  Rig rig;
  ASSERT_THAT(rig.runtime->LoadLibrary(rig.library()), IsOk());
  Actor actor(rig);
  PoseBuffer pose(4);
  for (const int clip : {0, 1, 2}) {
    const int frame = 3 * clip + 1;
    ASSERT_THAT(rig.runtime->Play(rig.toy.library->clip(clip).name(),
                                  frame / 30.0, Runtime::Align::kNone),
                IsOk());
    actor.Begin(clip, frame);
    pose.Read(*rig.toy.character, actor.data());
    ASSERT_THAT(rig.runtime->Reset(pose.pose(), nullptr), IsOk());
    for (int step = 0; step < 40; ++step) {
      actor.Act();
      pose.Read(*rig.toy.character, actor.data());

      ASSERT_THAT(rig.runtime->Step(pose.pose(), absl::MakeSpan(rig.target)),
                  IsOk());

      ASSERT_EQ(std::vector<float>(rig.runtime->observation().begin(),
                                   rig.runtime->observation().end()),
                actor.observation)
          << "clip " << clip << " step " << step;
      ASSERT_EQ(rig.target, actor.target)
          << "clip " << clip << " step " << step;
      if (actor.Step().diverged) break;
    }
  }
}

// Recovery on, goals in body space, drives of their own.
void UseVariants(v1::Task& task) {
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

TEST(Runtime, FollowsAReferenceOutOfSightAsAnActorDoes) {
  Rig rig(UseVariants);
  ASSERT_THAT(rig.runtime->LoadLibrary(rig.library()), IsOk());
  Actor actor(rig);
  PoseBuffer pose(4);
  for (const double away : {0.0, 6.0}) {
    ASSERT_THAT(rig.runtime->Play("turn", 0.1, Runtime::Align::kNone), IsOk());
    actor.Begin(0, 3);
    actor.MoveBy(away);
    pose.Read(*rig.toy.character, actor.data());
    ASSERT_THAT(rig.runtime->Reset(pose.pose(), nullptr), IsOk());
    for (int step = 0; step < 10; ++step) {
      actor.Act();
      pose.Read(*rig.toy.character, actor.data());

      ASSERT_THAT(rig.runtime->Step(pose.pose(), absl::MakeSpan(rig.target)),
                  IsOk());

      ASSERT_EQ(std::vector<float>(rig.runtime->observation().begin(),
                                   rig.runtime->observation().end()),
                actor.observation)
          << away << " m away, step " << step;
      ASSERT_EQ(rig.target, actor.target) << away << " m away, step " << step;
      if (actor.Step().diverged) break;
    }
  }
}

TEST(Runtime, MovesTheBodyByTheDrivesOfItsBundle) {
  Rig rig(UseVariants);
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

// The given-frame reference of a clip: what a caller would make of it.
class GivenFrames {
 public:
  GivenFrames(Runtime& runtime) : runtime_(runtime) {
    for (size_t i = 0; i < runtime.frames().size(); ++i) {
      buffers_.push_back(std::make_unique<PoseBuffer>(runtime.num_joints()));
    }
  }
  std::vector<Pose> Read() {
    std::vector<Pose> poses;
    for (size_t i = 0; i < buffers_.size(); ++i) {
      EXPECT_THAT(
          runtime_.ReadReference(runtime_.frames()[i], buffers_[i].get()),
          IsOk());
      poses.push_back(buffers_[i]->pose());
      poses.back().contact = contact_;
    }
    return poses;
  }

 private:
  Runtime& runtime_;
  std::vector<std::unique_ptr<PoseBuffer>> buffers_;
  const double contact_[2] = {1, 1};
};

TEST(Runtime, GivenFramesAndTheLibrarysAgree) {
  Rig rig;
  ASSERT_THAT(rig.runtime->LoadLibrary(rig.library()), IsOk());
  ASSERT_THAT(rig.runtime->Play("turn", 0.5, Runtime::Align::kNone), IsOk());
  Simulation body(*rig.runtime);
  ASSERT_THAT(body.Start(*rig.runtime), IsOk());
  GivenFrames frames(*rig.runtime);
  std::vector<double> given(4);
  for (int step = 0; step < 30; ++step) {
    ASSERT_THAT(
        rig.runtime->StepTo(body.pose(), frames.Read(), absl::MakeSpan(given)),
        IsOk());
    const std::vector<float> observation(rig.runtime->observation().begin(),
                                         rig.runtime->observation().end());
    Pose state = body.pose();
    ASSERT_THAT(rig.runtime->Reset(state, nullptr), IsOk());
    ASSERT_THAT(
        rig.runtime->StepTo(state, frames.Read(), absl::MakeSpan(given)),
        IsOk());
    ASSERT_THAT(rig.runtime->Reset(state, nullptr), IsOk());

    ASSERT_THAT(rig.runtime->Step(state, body.target()), IsOk());

    for (size_t i = 0; i < observation.size(); ++i) {
      if (step == 0) {
        // float32 rows against float64 kinematics.
        EXPECT_NEAR(rig.runtime->observation()[i], observation[i], 2e-4) << i;
      }
    }
    for (int j = 0; j < 4; ++j) EXPECT_NEAR(given[j], body.target()[j], 1e-3);
    ASSERT_THAT(body.Step(), IsOk());
  }
}

TEST(Runtime, WantsTheFramesThatThePolicyLooksAtAndTheNext) {
  const Rig rig;

  EXPECT_THAT(rig.runtime->frames(), ElementsAre(2, 7, 1));
  EXPECT_TRUE(rig.runtime->reference_needs().contact);
  EXPECT_FALSE(rig.runtime->reference_needs().torque);
}

TEST(Runtime, AlignsAClipToWhereTheBodyStands) {
  Rig rig;
  ASSERT_THAT(rig.runtime->LoadLibrary(rig.library()), IsOk());
  ASSERT_THAT(rig.runtime->Play("turn", 0, Runtime::Align::kNone), IsOk());
  Simulation body(*rig.runtime);
  ASSERT_THAT(body.Start(*rig.runtime), IsOk());
  ASSERT_THAT(rig.runtime->Step(body.pose(), body.target()), IsOk());
  const std::vector<float> at_home(rig.runtime->observation().begin(),
                                   rig.runtime->observation().end());
  // The same body elsewhere, turned by 2 rad.
  PoseBuffer moved(4);
  moved.Read(*rig.toy.character, body.data());
  moved.Move(Eigen::Quaterniond(std::cos(1), 0, 0, std::sin(1)),
             Eigen::Vector3d(5, -3, 0));

  ASSERT_THAT(rig.runtime->Play("turn", 0, Runtime::Align::kToBody), IsOk());
  ASSERT_THAT(rig.runtime->Reset(moved.pose(), nullptr), IsOk());
  ASSERT_THAT(rig.runtime->Step(moved.pose(), body.target()), IsOk());

  for (size_t i = 0; i < at_home.size(); ++i) {
    EXPECT_NEAR(rig.runtime->observation()[i], at_home[i], 2e-5) << i;
  }
}

TEST(Runtime, EstimatesWhatAnImuCannotGive) {
  Rig rig;
  ASSERT_THAT(rig.runtime->LoadLibrary(rig.library()), IsOk());
  ASSERT_THAT(rig.runtime->Play("sway", 0, Runtime::Align::kNone), IsOk());
  Simulation body(*rig.runtime);
  ASSERT_THAT(body.Start(*rig.runtime), IsOk());
  for (int step = 0; step < 10; ++step) {
    ASSERT_THAT(rig.runtime->Step(body.pose(), body.target()), IsOk());
    ASSERT_THAT(body.Step(), IsOk());
  }
  Pose imu = body.pose();
  ASSERT_THAT(rig.runtime->Step(imu, absl::MakeSpan(rig.target)), IsOk());
  const float height = rig.runtime->observation()[0];
  const float speed = rig.runtime->observation()[7];
  imu.root_position = nullptr;
  imu.root_linear_velocity = nullptr;

  ASSERT_THAT(rig.runtime->Step(imu, absl::MakeSpan(rig.target)), IsOk());

  // The toy stands on four legs: height by its soles, no speed to speak of.
  EXPECT_NEAR(rig.runtime->observation()[0], height, 0.02);
  EXPECT_NEAR(rig.runtime->observation()[7], speed, 0.2);
}

TEST(Runtime, TakesTheCallersPreviousTarget) {
  Rig rig;
  ASSERT_THAT(rig.runtime->LoadLibrary(rig.library()), IsOk());
  ASSERT_THAT(rig.runtime->Play("sway", 0, Runtime::Align::kNone), IsOk());
  Simulation body(*rig.runtime);
  ASSERT_THAT(body.Start(*rig.runtime), IsOk());
  Pose state = body.pose();
  const double previous[4] = {1, 2, 3, 4};
  state.previous_target = previous;

  ASSERT_THAT(rig.runtime->Step(state, absl::MakeSpan(rig.target)), IsOk());

  // Blocks: self 33, differences 2 x 35, previous target 4.
  for (int j = 0; j < 4; ++j) {
    EXPECT_FLOAT_EQ(rig.runtime->observation()[33 + 70 + j],
                    previous[j] - state.joint_position[j]);
  }
}

TEST(Runtime, NamesNumbersThatAreMissingOrNotFinite) {
  Rig rig;
  ASSERT_THAT(rig.runtime->LoadLibrary(rig.library()), IsOk());
  ASSERT_THAT(rig.runtime->Play("sway", 0, Runtime::Align::kNone), IsOk());
  Simulation body(*rig.runtime);
  ASSERT_THAT(body.Start(*rig.runtime), IsOk());
  Pose state = body.pose();
  const double bad[4] = {0, 0, NAN, 0};
  state.joint_velocity = bad;
  EXPECT_THAT(rig.runtime->Step(state, absl::MakeSpan(rig.target)),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("state.joint_velocity[2]: expected a finite "
                                 "number, found nan")));
  state.joint_velocity = nullptr;
  EXPECT_THAT(rig.runtime->Step(state, absl::MakeSpan(rig.target)),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("state.joint_velocity: expected 4 numbers, "
                                 "found NULL")));
  state = body.pose();
  const double long_quaternion[4] = {1, 1, 0, 0};
  state.root_rotation = long_quaternion;
  EXPECT_THAT(
      rig.runtime->Step(state, absl::MakeSpan(rig.target)),
      StatusIs(absl::StatusCode::kInvalidArgument,
               HasSubstr("expected a unit quaternion, found norm 1.41")));
}

TEST(Runtime, SaysWhichCallIsMissing) {
  Rig rig;
  Simulation body(*rig.runtime);
  EXPECT_THAT(rig.runtime->Play("sway", 0, Runtime::Align::kNone),
              StatusIs(absl::StatusCode::kFailedPrecondition,
                       HasSubstr("motion library")));
  EXPECT_THAT(rig.runtime->Reset(body.pose(), nullptr),
              StatusIs(absl::StatusCode::kFailedPrecondition,
                       HasSubstr("expected a clip to play or a reference")));
  EXPECT_THAT(rig.runtime->Step(body.pose(), absl::MakeSpan(rig.target)),
              StatusIs(absl::StatusCode::kFailedPrecondition,
                       HasSubstr("expected a reset first")));
  ASSERT_THAT(rig.runtime->LoadLibrary(rig.library()), IsOk());
  EXPECT_THAT(rig.runtime->Play("swim", 0, Runtime::Align::kNone),
              StatusIs(absl::StatusCode::kNotFound,
                       AllOf(HasSubstr("turn, sway, tumble"),
                             HasSubstr("found \"swim\""))));
}

TEST(Runtime, NeedsTorquesWhereTheActionLawFoldsThemIn) {
  const Rig rig([](v1::Task& task) {
    task.mutable_action()->set_torque_feedforward(true);
  });
  Simulation body(*rig.runtime);
  Pose reference = body.pose();
  const double contact[2] = {1, 1};
  reference.contact = contact;

  EXPECT_THAT(rig.runtime->Reset(body.pose(), &reference),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("reference.feedforward_torque: expected 4 "
                                 "numbers, found NULL")));
}

TEST(Runtime, HoldsTheEndOfAClip) {
  Rig rig;
  ASSERT_THAT(rig.runtime->LoadLibrary(rig.library()), IsOk());
  ASSERT_THAT(rig.runtime->Play("sway", 18 / 30.0, Runtime::Align::kNone),
              IsOk());
  Simulation body(*rig.runtime);
  ASSERT_THAT(body.Start(*rig.runtime), IsOk());
  EXPECT_FALSE(rig.runtime->is_over());

  ASSERT_THAT(rig.runtime->Step(body.pose(), body.target()), IsOk());

  EXPECT_TRUE(rig.runtime->is_over());
  EXPECT_THAT(rig.runtime->Step(body.pose(), body.target()), IsOk());
}

TEST(Runtime, RefusesABundleThatIsNone) {
  EXPECT_THAT(Runtime::Open("/nowhere"),
              StatusIs(absl::StatusCode::kNotFound, HasSubstr("/nowhere")));
}

}  // namespace
}  // namespace sinew::runtime
