// What the runtime plays from the frame that is nearest to a body.
#include <cmath>
#include <vector>

#include "common/testing/matchers.h"
#include "deploy/runtime/pose.h"
#include "deploy/runtime/runtime.h"
#include "deploy/runtime/simulation.h"
#include "deploy/runtime/testing/runtime_rig.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "sim/world/testing/toy_world.h"

namespace sinew::runtime {
namespace {

using ::sinew::testing::IsOk;
using ::sinew::testing::StatusIs;
using ::testing::HasSubstr;
using testing::RuntimeRig;

// A body on a frame of a clip, then elsewhere on the floor, turned by 2 rad.
class MovedBody {
 public:
  MovedBody(RuntimeRig& rig, absl::string_view clip, double seconds)
      : buffer_(rig.runtime->num_joints()) {
    EXPECT_THAT(rig.runtime->Play(clip, seconds, Runtime::Align::kNone),
                IsOk());
    EXPECT_THAT(rig.runtime->ReadReference(0, &buffer_), IsOk());
    buffer_.Move(Eigen::Quaterniond(std::cos(1), 0, 0, std::sin(1)),
                 Eigen::Vector3d(5, -3, 0));
  }
  const Pose& pose() const { return buffer_.pose(); }

 private:
  PoseBuffer buffer_;
};

TEST(RuntimeNearest, PlaysFromTheFrameThatIsNearestToTheBody) {
  RuntimeRig rig;
  ASSERT_THAT(rig.runtime->LoadLibrary(rig.library()), IsOk());
  const MovedBody body(rig, "turn", 9 / 30.0);
  ASSERT_THAT(rig.runtime->Play("turn", 9 / 30.0, Runtime::Align::kToBody),
              IsOk());
  ASSERT_THAT(rig.runtime->Reset(body.pose(), nullptr), IsOk());
  ASSERT_THAT(rig.runtime->Step(body.pose(), absl::MakeSpan(rig.target)),
              IsOk());
  const std::vector<float> expected(rig.runtime->observation().begin(),
                                    rig.runtime->observation().end());
  ASSERT_THAT(rig.runtime->Play("sway", 0, Runtime::Align::kNone), IsOk());

  const auto distance =
      rig.runtime->PlayNearest(body.pose(), Runtime::Among::kAll, /*stand=*/0);

  ASSERT_THAT(distance, IsOk());
  EXPECT_LT(*distance, 1e-5);
  EXPECT_EQ(rig.runtime->clip_name(), "turn");
  EXPECT_NEAR(rig.runtime->clip_seconds(), 9 / 30.0, 1e-9);
  ASSERT_THAT(rig.runtime->Reset(body.pose(), nullptr), IsOk());
  ASSERT_THAT(rig.runtime->Step(body.pose(), absl::MakeSpan(rig.target)),
              IsOk());
  for (size_t i = 0; i < expected.size(); ++i) {
    // Blocks: self 33, differences 2 x 35, previous target 4 (which a reset
    // sets otherwise here), the rest.
    if (i >= 103 && i < 107) continue;
    EXPECT_NEAR(rig.runtime->observation()[i], expected[i], 2e-5) << i;
  }
  EXPECT_NEAR(rig.runtime->clip_seconds(), 10 / 30.0, 1e-9);
}

// As training begins on the floor, where joints rest anywhere.
TEST(RuntimeNearest, BeginsWithTheJointsWhereTheyAre) {
  RuntimeRig rig;
  ASSERT_THAT(rig.runtime->LoadLibrary(rig.library()), IsOk());
  const MovedBody body(rig, "turn", 9 / 30.0);
  ASSERT_THAT(rig.runtime->PlayNearest(body.pose(), Runtime::Among::kAll, 0),
              IsOk());

  ASSERT_THAT(rig.runtime->Reset(body.pose(), nullptr), IsOk());

  EXPECT_THAT(rig.runtime->previous_target(),
              ::testing::ElementsAreArray(body.pose().joint_position, 4));
}

TEST(RuntimeNearest, LetsTheNearestFrameStandAndTheEpisodeGoOn) {
  RuntimeRig rig;
  ASSERT_THAT(rig.runtime->LoadLibrary(rig.library()), IsOk());
  const MovedBody body(rig, "turn", 9 / 30.0);
  ASSERT_THAT(rig.runtime->Reset(body.pose(), nullptr), IsOk());
  const std::vector<double> before(rig.runtime->previous_target().begin(),
                                   rig.runtime->previous_target().end());

  ASSERT_THAT(
      rig.runtime->PlayNearest(body.pose(), Runtime::Among::kUpright, 3),
      IsOk());

  EXPECT_THAT(rig.runtime->previous_target(),
              ::testing::ElementsAreArray(before));
  for (const double frame : {9, 9, 9, 10, 11}) {
    ASSERT_THAT(rig.runtime->Step(body.pose(), absl::MakeSpan(rig.target)),
                IsOk());
    EXPECT_NEAR(rig.runtime->clip_seconds(), frame / 30, 1e-9);
  }
  // Whoever seeks wants to move on.
  ASSERT_THAT(
      rig.runtime->PlayNearest(body.pose(), Runtime::Among::kUpright, 3),
      IsOk());
  ASSERT_THAT(rig.runtime->Seek(0.5), IsOk());
  ASSERT_THAT(rig.runtime->Step(body.pose(), absl::MakeSpan(rig.target)),
              IsOk());
  EXPECT_NEAR(rig.runtime->clip_seconds(), 16 / 30.0, 1e-9);
}

TEST(RuntimeNearest, PlaysNearestFramesOfTheKindThatIsAskedFor) {
  RuntimeRig rig([](v1::Task&) {}, world::testing::ToyClips::kWithGetUp);
  ASSERT_THAT(rig.runtime->LoadLibrary(rig.library()), IsOk());
  const MovedBody standing(rig, "turn", 0);
  const MovedBody low(rig, "sway", 2 / 30.0);

  ASSERT_THAT(
      rig.runtime->PlayNearest(standing.pose(), Runtime::Among::kGetUps, 0),
      IsOk());
  EXPECT_EQ(rig.runtime->clip_name(), "sway");
  EXPECT_LT(rig.runtime->clip_seconds(), 7 / 30.0);
  const auto distance =
      rig.runtime->PlayNearest(low.pose(), Runtime::Among::kUpright, 0);
  ASSERT_THAT(distance, IsOk());
  EXPECT_EQ(rig.runtime->clip_name(), "turn");
  EXPECT_GT(*distance, 0.05);  // the trunk of the one is 0.1 m lower
}

TEST(RuntimeNearest, FindsFramesOfTheLibraryThatIsLoaded) {
  RuntimeRig rig;
  const RuntimeRig other([](v1::Task&) {},
                         world::testing::ToyClips::kWithGetUp);
  ASSERT_THAT(rig.runtime->LoadLibrary(other.library()), IsOk());
  const MovedBody low(rig, "sway", 0);
  const auto play = [&](Runtime::Among among) {
    return rig.runtime->PlayNearest(low.pose(), among, 0).status();
  };
  ASSERT_THAT(play(Runtime::Among::kGetUps), IsOk());

  ASSERT_THAT(rig.runtime->LoadLibrary(rig.library()), IsOk());

  EXPECT_THAT(play(Runtime::Among::kGetUps),
              StatusIs(absl::StatusCode::kNotFound, HasSubstr("a get-up")));
}

// Whose place in the plane is the reference's, and whose height is its soles'.
TEST(RuntimeNearest, PlaysFromTheNearestFrameOfABodyThatKnowsNoPlace) {
  RuntimeRig rig;
  ASSERT_THAT(rig.runtime->LoadLibrary(rig.library()), IsOk());
  const MovedBody body(rig, "turn", 9 / 30.0);
  Pose imu = body.pose();
  imu.root_position = nullptr;
  imu.root_linear_velocity = nullptr;
  ASSERT_THAT(rig.runtime->Play("sway", 0, Runtime::Align::kToBody), IsOk());

  const auto distance =
      rig.runtime->PlayNearest(imu, Runtime::Among::kUpright, 0);

  ASSERT_THAT(distance, IsOk());
  EXPECT_LT(*distance, 0.05);
  EXPECT_EQ(rig.runtime->clip_name(), "turn");
  // No alignment is left for the reset, which would turn it away.
  ASSERT_THAT(rig.runtime->Reset(imu, nullptr), IsOk());
  PoseBuffer now(4);
  ASSERT_THAT(rig.runtime->ReadReference(0, &now), IsOk());
  double same = 0;  // of unit quaternions
  for (int i = 0; i < 4; ++i) {
    same += now.pose().root_rotation[i] * body.pose().root_rotation[i];
  }
  EXPECT_GT(std::abs(same), 0.99);
}

TEST(RuntimeNearest, SaysHowLongGetUpsStoodInItsTraining) {
  EXPECT_EQ(RuntimeRig().runtime->get_up_steps(), 0);
  const RuntimeRig rig([](v1::Task& task) {
    task.mutable_recovery()->set_get_up_share(0.5);
    task.mutable_recovery()->set_get_up_steps(12);
  });
  EXPECT_EQ(rig.runtime->get_up_steps(), 12);
}

TEST(RuntimeNearest, SaysWhyNoFrameIsNearest) {
  RuntimeRig rig;
  Simulation body(*rig.runtime);
  const auto play = [&](Runtime::Among among, int stand) {
    return rig.runtime->PlayNearest(body.pose(), among, stand).status();
  };
  EXPECT_THAT(play(Runtime::Among::kAll, 0),
              StatusIs(absl::StatusCode::kFailedPrecondition,
                       HasSubstr("motion library")));
  EXPECT_EQ(rig.runtime->clip_name(), "");
  EXPECT_EQ(rig.runtime->clip_seconds(), 0);
  ASSERT_THAT(rig.runtime->LoadLibrary(rig.library()), IsOk());
  ASSERT_THAT(rig.runtime->Play("sway", 0.2, Runtime::Align::kNone), IsOk());
  EXPECT_THAT(play(Runtime::Among::kGetUps, 0),
              StatusIs(absl::StatusCode::kNotFound,
                       HasSubstr("expected the library to have a get-up")));
  EXPECT_THAT(play(Runtime::Among::kAll, -1),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       "stand: expected 0 to 65536 steps, found -1"));
  EXPECT_EQ(rig.runtime->clip_name(), "sway");
  EXPECT_NEAR(rig.runtime->clip_seconds(), 0.2, 1e-9);
}

}  // namespace
}  // namespace sinew::runtime
