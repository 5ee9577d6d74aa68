#include "deploy/runtime/runtime.h"

#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "common/testing/matchers.h"
#include "deploy/runtime/pose.h"
#include "deploy/runtime/simulation.h"
#include "deploy/runtime/testing/runtime_rig.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace sinew::runtime {
namespace {

using ::sinew::testing::IsOk;
using ::sinew::testing::StatusIs;
using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using testing::RuntimeRig;

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

// Plays a clip of the rig's library from that second on.
void Play(const std::string& clip, double seconds, RuntimeRig& rig) {
  ASSERT_THAT(rig.runtime->LoadLibrary(rig.library()), IsOk());
  ASSERT_THAT(rig.runtime->Play(clip, seconds, Runtime::Align::kNone), IsOk());
}

TEST(Runtime, GivenFramesAndTheLibrarysAgree) {
  RuntimeRig rig;
  Play("turn", 0.5, rig);
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
  const RuntimeRig rig;

  EXPECT_THAT(rig.runtime->frames(), ElementsAre(2, 7, 1));
  EXPECT_TRUE(rig.runtime->reference_needs().contact);
  EXPECT_FALSE(rig.runtime->reference_needs().torque);
}

TEST(Runtime, NamesTheFrameThatIsWrong) {
  RuntimeRig rig;
  Play("turn", 0.5, rig);
  Simulation body(*rig.runtime);
  ASSERT_THAT(body.Start(*rig.runtime), IsOk());
  GivenFrames frames(*rig.runtime);
  std::vector<Pose> poses = frames.Read();
  poses[1].joint_position = nullptr;
  std::vector<double> target(4);

  EXPECT_THAT(
      rig.runtime->StepTo(body.pose(), poses, absl::MakeSpan(target)),
      StatusIs(absl::StatusCode::kInvalidArgument,
               HasSubstr("frames[1].joint_position: expected 4 numbers")));
}

TEST(Runtime, AlignsAClipToWhereTheBodyStands) {
  RuntimeRig rig;
  Play("turn", 0, rig);
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

  // And where the next episode begins.
  moved.Move(Eigen::Quaterniond(std::cos(0.5), 0, 0, std::sin(0.5)),
             Eigen::Vector3d(-20, 7, 0));
  ASSERT_THAT(rig.runtime->Seek(0), IsOk());
  ASSERT_THAT(rig.runtime->Reset(moved.pose(), nullptr), IsOk());
  ASSERT_THAT(rig.runtime->Step(moved.pose(), body.target()), IsOk());

  for (size_t i = 0; i < at_home.size(); ++i) {
    EXPECT_NEAR(rig.runtime->observation()[i], at_home[i], 5e-5) << i;
  }
}

TEST(Runtime, EstimatesWhatAnImuCannotGive) {
  RuntimeRig rig;
  Play("sway", 0, rig);
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
  RuntimeRig rig;
  Play("sway", 0, rig);
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
  RuntimeRig rig;
  Play("sway", 0, rig);
  Simulation body(*rig.runtime);
  ASSERT_THAT(body.Start(*rig.runtime), IsOk());
  Pose state = body.pose();
  const double bad[4] = {0, 0, NAN, 0};
  state.joint_velocity = bad;
  EXPECT_THAT(rig.runtime->Step(state, absl::MakeSpan(rig.target)),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("state.joint_velocity[2]: expected a finite "
                                 "float32, found nan")));
  const double huge[4] = {0, 1e200, 0, 0};
  state.joint_velocity = huge;
  EXPECT_THAT(rig.runtime->Step(state, absl::MakeSpan(rig.target)),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("state.joint_velocity[1]: expected a finite "
                                 "float32, found 1e+200")));
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

TEST(Runtime, RefusesNumbersThatAreTooLargeTogether) {
  RuntimeRig rig;
  Play("sway", 0, rig);
  Simulation body(*rig.runtime);
  ASSERT_THAT(body.Start(*rig.runtime), IsOk());
  Pose state = body.pose();
  const double far[3] = {3e38, -3e38, 1};
  state.root_position = far;

  EXPECT_THAT(rig.runtime->Step(state, absl::MakeSpan(rig.target)),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("of this state and reference: expected a "
                                 "finite float32, found")));
}

TEST(Runtime, SaysWhichCallIsMissing) {
  RuntimeRig rig;
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
  const RuntimeRig rig([](v1::Task& task) {
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
  RuntimeRig rig;
  Play("sway", 18 / 30.0, rig);
  Simulation body(*rig.runtime);
  ASSERT_THAT(body.Start(*rig.runtime), IsOk());
  EXPECT_FALSE(rig.runtime->is_over());

  ASSERT_THAT(rig.runtime->Step(body.pose(), body.target()), IsOk());

  EXPECT_TRUE(rig.runtime->is_over());
  const double end = rig.runtime->clip_seconds();
  EXPECT_THAT(rig.runtime->Step(body.pose(), body.target()), IsOk());
  EXPECT_EQ(rig.runtime->clip_seconds(), end);
  EXPECT_THAT(rig.runtime->Seek(1000), IsOk());
  EXPECT_EQ(rig.runtime->clip_seconds(), end);
}

TEST(Runtime, RefusesABundleThatIsNone) {
  EXPECT_THAT(Runtime::Open("/nowhere"),
              StatusIs(absl::StatusCode::kNotFound, HasSubstr("/nowhere")));
}

}  // namespace
}  // namespace sinew::runtime
