// Encode, prior, decode and sample against each other and against Step.
#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "common/files.h"
#include "common/testing/matchers.h"
#include "deploy/bundle/testing/toy_latent.h"
#include "deploy/runtime/pose.h"
#include "deploy/runtime/runtime.h"
#include "deploy/runtime/simulation.h"
#include "deploy/runtime/testing/runtime_rig.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "proto/sinew/v1/recipe.pb.h"
#include "sim/world/testing/toy_world.h"

namespace sinew::runtime {
namespace {

using ::sinew::testing::IsOk;
using ::sinew::testing::StatusIs;
using ::testing::HasSubstr;
using testing::RuntimeRig;

constexpr int kWidth = 6;
using Latent = std::vector<double>;

// Two runtimes of one bundle with a latent, and a body that both look at.
struct LatentRig {
  explicit LatentRig(
      const v1::Recipe& recipe = bundle::testing::ToyLatentRecipe(),
      const bundle::testing::LatentWidths& widths = {})
      : toy(world::testing::MakeToyWorld(recipe)) {
    const std::string directory = bundle::testing::WriteToyLatent(toy, widths);
    stepping = *Runtime::Open(directory);
    steered = *Runtime::Open(directory);
    for (Runtime* runtime : {stepping.get(), steered.get()}) {
      EXPECT_THAT(runtime->LoadLibrary(toy.library_folder), IsOk());
      EXPECT_THAT(runtime->Play("turn", 0, Runtime::Align::kNone), IsOk());
    }
    body = std::make_unique<Simulation>(*stepping);
    EXPECT_THAT(body->Start(*stepping), IsOk());
    EXPECT_THAT(steered->Reset(body->pose(), nullptr), IsOk());
  }

  world::testing::ToyWorld toy;
  std::unique_ptr<Runtime> stepping, steered;
  std::unique_ptr<Simulation> body;
  Latent mean = Latent(kWidth), std = Latent(kWidth);
  std::vector<double> target = std::vector<double>(4);
};

std::vector<double> TargetOf(Runtime& runtime, const Pose& pose,
                             const Latent& latent) {
  std::vector<double> target(4);
  EXPECT_THAT(runtime.Decode(pose, latent, absl::MakeSpan(target)), IsOk());
  return target;
}

void ExpectDecodedMeansAreSteps(LatentRig& rig, int steps) {
  for (int step = 0; step < steps; ++step) {
    SCOPED_TRACE(step);
    ASSERT_THAT(rig.steered->Encode(rig.body->pose(), absl::MakeSpan(rig.mean),
                                    absl::MakeSpan(rig.std)),
                IsOk());
    const auto steered = TargetOf(*rig.steered, rig.body->pose(), rig.mean);

    ASSERT_THAT(rig.stepping->Step(rig.body->pose(), rig.body->target()),
                IsOk());

    EXPECT_EQ(steered, std::vector<double>(rig.body->target().begin(),
                                           rig.body->target().end()));
    EXPECT_EQ(rig.steered->previous_target(), rig.stepping->previous_target());
    ASSERT_THAT(rig.body->Step(), IsOk());
  }
}

TEST(LatentRuntime, DecodedMeansAreTheStepsOfThePolicyBitForBit) {
  LatentRig rig;
  ExpectDecodedMeansAreSteps(rig, 40);
}

TEST(LatentRuntime, ItsStateAndGoalMayBeThoseOfBodies) {
  v1::Recipe recipe = bundle::testing::ToyLatentRecipe();
  v1::Observation& observation = *recipe.mutable_task()->mutable_observation();
  observation.clear_blocks();
  observation.add_blocks(v1::Observation::BLOCK_SELF_BODIES);
  observation.add_blocks(v1::Observation::BLOCK_REFERENCE_BODIES);
  const int own = 15 * 5 - 2;
  LatentRig rig(recipe, {.self = own, .observation = own + 24 * 5});
  ASSERT_EQ(rig.steered->self_observation_width(), own);
  ExpectDecodedMeansAreSteps(rig, 10);
  const auto fresh = *Runtime::Open(JoinPath(rig.toy.folder, "bundle"));
  EXPECT_THAT(fresh->Sample(rig.body->pose(), Latent(kWidth),
                            absl::MakeSpan(rig.target)),
              IsOk());
}

TEST(LatentRuntime, GivenFramesAreEncodedAsTheyAreSteppedTo) {
  LatentRig rig;
  PoseBuffer frame(4);
  ASSERT_THAT(rig.stepping->ReadReference(1, &frame), IsOk());
  const Pose given = frame.pose();

  ASSERT_THAT(
      rig.steered->EncodeTo(rig.body->pose(), {&given, 1},
                            absl::MakeSpan(rig.mean), absl::MakeSpan(rig.std)),
      IsOk());
  const auto steered = TargetOf(*rig.steered, rig.body->pose(), rig.mean);

  ASSERT_THAT(rig.stepping->StepTo(rig.body->pose(), {&given, 1},
                                   absl::MakeSpan(rig.target)),
              IsOk());
  EXPECT_EQ(steered, rig.target);
}

TEST(LatentRuntime, TheReferenceMattersToTheEncoderAlone) {
  LatentRig rig;
  Latent later(kWidth);
  const Pose& pose = rig.body->pose();
  ASSERT_THAT(rig.steered->Encode(pose, absl::MakeSpan(rig.mean),
                                  absl::MakeSpan(rig.std)),
              IsOk());
  const auto before = TargetOf(*rig.steered, pose, rig.mean);

  ASSERT_THAT(
      rig.steered->Encode(pose, absl::MakeSpan(later), absl::MakeSpan(rig.std)),
      IsOk());

  EXPECT_NE(later, rig.mean);
  EXPECT_EQ(TargetOf(*rig.steered, pose, rig.mean), before);
}

TEST(LatentRuntime, SamplesArePriorAndDecoderBitForBit) {
  LatentRig rig;
  const Pose& pose = rig.body->pose();
  // Powers of two: their products round nothing, fused or not.
  const Latent noise = {0, 1, -0.5, 2, -1, 0.25};
  ASSERT_THAT(rig.steered->Prior(pose, absl::MakeSpan(rig.mean),
                                 absl::MakeSpan(rig.std)),
              IsOk());
  Latent latent(kWidth);
  for (int i = 0; i < kWidth; ++i) {
    EXPECT_GT(rig.std[i], 0);
    latent[i] = static_cast<float>(rig.mean[i]) +
                static_cast<float>(rig.std[i] * noise[i]);
  }

  ASSERT_THAT(rig.steered->Sample(pose, noise, absl::MakeSpan(rig.target)),
              IsOk());

  EXPECT_EQ(rig.target, TargetOf(*rig.steered, pose, latent));
  EXPECT_NE(rig.target, TargetOf(*rig.steered, pose, rig.mean));
}

TEST(LatentRuntime, NeedsNeitherReferenceNorResetToSample) {
  LatentRig rig;
  const auto fresh = *Runtime::Open(JoinPath(rig.toy.folder, "bundle"));

  EXPECT_THAT(fresh->Sample(rig.body->pose(), Latent(kWidth),
                            absl::MakeSpan(rig.target)),
              IsOk());

  EXPECT_EQ(rig.target, std::vector<double>(fresh->previous_target().begin(),
                                            fresh->previous_target().end()));
  EXPECT_THAT(fresh->Reset(rig.body->pose(), nullptr), IsOk());
  EXPECT_EQ(fresh->previous_target()[2], rig.body->pose().joint_position[2]);
}

TEST(LatentRuntime, WantsAPreviousTargetWhereTheBodysStateHasOne) {
  v1::Recipe recipe = bundle::testing::ToyLatentRecipe();
  v1::Observation& observation = *recipe.mutable_task()->mutable_observation();
  observation.clear_blocks();
  observation.add_blocks(v1::Observation::BLOCK_SELF_JOINT_SPACE);
  observation.add_blocks(v1::Observation::BLOCK_PREVIOUS_TARGET);
  observation.add_blocks(v1::Observation::BLOCK_SELF_CONTACT);
  observation.add_blocks(v1::Observation::BLOCK_REFERENCE_DIFFERENCE);
  LatentRig rig(recipe, {.self = 33 + 4 + 2, .observation = 39 + 35});
  const auto fresh = *Runtime::Open(JoinPath(rig.toy.folder, "bundle"));
  const auto target = absl::MakeSpan(rig.target);
  const Pose& pose = rig.body->pose();

  EXPECT_THAT(fresh->Sample(pose, Latent(kWidth), target),
              StatusIs(absl::StatusCode::kFailedPrecondition,
                       HasSubstr("state.previous_target: expected numbers or "
                                 "a reset first")));
  ASSERT_THAT(fresh->Reset(pose, nullptr), IsOk());
  EXPECT_THAT(fresh->Sample(pose, Latent(kWidth), target), IsOk());

  // The same parity as without.
  ASSERT_THAT(rig.steered->Encode(pose, absl::MakeSpan(rig.mean),
                                  absl::MakeSpan(rig.std)),
              IsOk());
  const auto steered = TargetOf(*rig.steered, pose, rig.mean);
  ASSERT_THAT(rig.stepping->Step(pose, target), IsOk());
  EXPECT_EQ(steered, rig.target);
}

TEST(LatentRuntime, TargetsStandAroundTheCurrentPose) {
  LatentRig rig;
  Pose bent = rig.body->pose();
  const auto straight = TargetOf(*rig.steered, bent, Latent(kWidth));
  std::vector<double> joints(bent.joint_position, bent.joint_position + 4);
  joints[0] += 1e-3;
  bent.joint_position = joints.data();

  EXPECT_NE(TargetOf(*rig.steered, bent, Latent(kWidth))[0], straight[0]);
  // The largest action is 8 units of 0.2 rad.
  EXPECT_NEAR(straight[0], rig.body->pose().joint_position[0], 1.6);
}

TEST(LatentRuntime, SelfObservationIsTheFirstPartOfTheObservation) {
  LatentRig rig;
  ASSERT_EQ(rig.steered->self_observation_width(), 33);
  std::vector<float> own(33);

  ASSERT_THAT(
      rig.steered->SelfObservation(rig.body->pose(), absl::MakeSpan(own)),
      IsOk());

  ASSERT_THAT(rig.stepping->Step(rig.body->pose(), absl::MakeSpan(rig.target)),
              IsOk());
  const auto whole = rig.stepping->observation();
  EXPECT_EQ(own, std::vector<float>(whole.begin(), whole.begin() + 33));
}

TEST(LatentRuntime, RefusesALatentOfTheWrongSize) {
  LatentRig rig;
  const auto refused = [](const char* message) {
    return StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr(message));
  };
  const Pose& pose = rig.body->pose();
  const auto target = absl::MakeSpan(rig.target);
  const auto five = absl::MakeSpan(rig.mean).first(5);
  const auto six = absl::MakeSpan(rig.std);

  EXPECT_THAT(rig.steered->Decode(pose, five, target),
              refused("latent: expected 6 numbers, as wide as the latent, "
                      "found 5"));
  EXPECT_THAT(rig.steered->Sample(pose, Latent(7), target),
              refused("noise: expected 6 numbers"));
  EXPECT_THAT(rig.steered->Prior(pose, five, six),
              refused("mean: expected 6 numbers"));
  EXPECT_THAT(rig.steered->Encode(pose, six, five),
              refused("std: expected 6 numbers"));
  EXPECT_THAT(rig.steered->Decode(pose, rig.mean, target.first(3)),
              refused("target: expected room for 4 joints, found 3"));
  std::vector<float> own(32);
  EXPECT_THAT(rig.steered->SelfObservation(pose, absl::MakeSpan(own)),
              refused("self_observation: expected room for 33 numbers"));
}

TEST(LatentRuntime, NamesTheNumberThatIsNotFinite) {
  LatentRig rig;
  rig.mean[4] = NAN;

  EXPECT_THAT(rig.steered->Decode(rig.body->pose(), rig.mean,
                                  absl::MakeSpan(rig.target)),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("latent[4]: expected a finite float32, found "
                                 "nan")));
  rig.mean[4] = 1e60;
  EXPECT_THAT(rig.steered->Sample(rig.body->pose(), rig.mean,
                                  absl::MakeSpan(rig.target)),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("noise[4]: expected a finite float32")));
}

TEST(LatentRuntime, EncodesOnlyAfterAReset) {
  LatentRig rig;
  ASSERT_THAT(rig.steered->Play("sway", 0, Runtime::Align::kNone), IsOk());

  EXPECT_THAT(rig.steered->Encode(rig.body->pose(), absl::MakeSpan(rig.mean),
                                  absl::MakeSpan(rig.std)),
              StatusIs(absl::StatusCode::kFailedPrecondition,
                       HasSubstr("encode: expected a reset first")));
}

TEST(LatentRuntime, SaysThatABundleHasNoLatent) {
  const RuntimeRig rig;
  Simulation body(*rig.runtime);
  std::vector<double> six(6), target(4);
  std::vector<float> own(33);
  const auto refused = StatusIs(absl::StatusCode::kFailedPrecondition,
                                HasSubstr("this bundle has no latent"));
  const auto numbers = absl::MakeSpan(six);

  EXPECT_EQ(rig.runtime->latent_width(), 0);
  EXPECT_EQ(rig.runtime->self_observation_width(), 0);
  EXPECT_THAT(rig.runtime->SelfObservation(body.pose(), absl::MakeSpan(own)),
              refused);
  EXPECT_THAT(rig.runtime->Encode(body.pose(), numbers, numbers), refused);
  EXPECT_THAT(rig.runtime->EncodeTo(body.pose(), {}, numbers, numbers),
              refused);
  EXPECT_THAT(rig.runtime->Prior(body.pose(), numbers, numbers), refused);
  EXPECT_THAT(rig.runtime->Decode(body.pose(), six, absl::MakeSpan(target)),
              refused);
  EXPECT_THAT(rig.runtime->Sample(body.pose(), six, absl::MakeSpan(target)),
              refused);
}

}  // namespace
}  // namespace sinew::runtime
