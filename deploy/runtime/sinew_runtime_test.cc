// The C interface, used from a C program.
#include "deploy/runtime/sinew_runtime.h"

#include <cmath>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "common/files.h"
#include "common/testing/matchers.h"
#include "deploy/bundle/bundle.h"
#include "deploy/bundle/testing/toy_bundle.h"
#include "deploy/bundle/testing/toy_latent.h"
#include "deploy/runtime/c_program.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "sim/world/testing/toy_world.h"

namespace sinew::runtime {
namespace {

using ::sinew::testing::IsOk;
using ::testing::HasSubstr;

// A bundle with a latent, opened, with a state to ask about.
struct LatentHandle {
  explicit LatentHandle(
      const v1::Recipe& recipe = bundle::testing::ToyLatentRecipe(),
      const bundle::testing::LatentWidths& widths = {}) {
    const world::testing::ToyWorld toy = world::testing::MakeToyWorld(recipe);
    const std::string path = bundle::testing::WriteToyLatent(toy, widths);
    policy = sinew_open(path.c_str(), nullptr, 0);
    EXPECT_EQ(sinew_load_library(policy, toy.library_folder.c_str()), 0);
    EXPECT_EQ(sinew_play(policy, "turn", 0, SINEW_ALIGN_NONE), 0);
    EXPECT_EQ(
        sinew_reference(policy, 0, position, rotation, velocity, rate, q, dq),
        0);
    state.joint_position = q;
    state.joint_velocity = dq;
    state.root_rotation = rotation;
    state.root_angular_velocity = rate;
    state.root_position = position;
    state.root_linear_velocity = velocity;
    EXPECT_EQ(sinew_reset(policy, &state, nullptr), 0);
  }
  ~LatentHandle() { sinew_close(policy); }

  sinew_runtime* policy = nullptr;
  double position[3], rotation[4], velocity[3], rate[3], q[4], dq[4];
  sinew_pose state = {};
  std::vector<double> mean = std::vector<double>(6);
  std::vector<double> spread = std::vector<double>(6);
  std::vector<double> target = std::vector<double>(4);
};

struct Paths {
  Paths() {
    const world::testing::ToyWorld toy = world::testing::MakeToyWorld();
    bundle = JoinPath(toy.folder, "bundle");
    library = JoinPath(toy.folder, "library");
    EXPECT_THAT(bundle::WriteBundle(bundle::testing::ToyContent(toy), bundle),
                IsOk());
  }
  std::string bundle, library;
};

TEST(CInterface, RunsFromC) {
  const Paths paths;
  double target = NAN;
  char error[200] = "";

  EXPECT_EQ(RunInC(paths.bundle.c_str(), paths.library.c_str(), "turn", &target,
                   error, sizeof error),
            0)
      << error;

  // The reference swings by 0.3 rad; the policy adds 0.2 rad per unit.
  EXPECT_LT(std::abs(target), 2.5);
  EXPECT_NE(target, 0);
}

TEST(CInterface, GivesErrorsAsText) {
  const Paths paths;
  double target = 0;
  char error[200] = "";

  EXPECT_EQ(RunInC("/nowhere", "", "", &target, error, sizeof error), -1);
  EXPECT_THAT(error, HasSubstr("/nowhere: expected a bundle"));
  EXPECT_EQ(RunInC(paths.bundle.c_str(), paths.library.c_str(), "swim", &target,
                   error, sizeof error),
            -1);
  EXPECT_THAT(error, HasSubstr("found \"swim\""));
  EXPECT_EQ(RunInC("/nowhere", "", "", &target, error, 9), -1);
  EXPECT_STREQ(error, "/nowhere");
}

TEST(CInterface, PlaysFromTheNearestFrame) {
  LatentHandle handle;
  double distance = -1;

  ASSERT_EQ(sinew_play_nearest(handle.policy, &handle.state, SINEW_AMONG_ALL, 2,
                               &distance),
            0);

  EXPECT_GE(distance, 0);
  EXPECT_LT(distance, 1e-5);
  EXPECT_STREQ(sinew_clip_playing(handle.policy), "turn");
  EXPECT_EQ(sinew_clip_seconds(handle.policy), 0);
  EXPECT_EQ(sinew_play_nearest(handle.policy, &handle.state,
                               SINEW_AMONG_UPRIGHT, 0, nullptr),
            0);
  EXPECT_EQ(sinew_play_nearest(handle.policy, &handle.state,
                               SINEW_AMONG_GET_UPS, 0, &distance),
            -1);
  EXPECT_THAT(sinew_error(handle.policy), HasSubstr("a get-up"));
  EXPECT_EQ(sinew_play_nearest(handle.policy, &handle.state, 3, 0, &distance),
            -1);
  EXPECT_THAT(sinew_error(handle.policy),
              HasSubstr("among: expected one of SINEW_AMONG_..., found 3"));
  EXPECT_EQ(sinew_get_up_steps(handle.policy), 0);
  EXPECT_EQ(sinew_play_nearest(handle.policy, nullptr, 0, 0, &distance), -1);
  EXPECT_THAT(sinew_error(handle.policy), HasSubstr("state"));
}

TEST(CInterface, RefusesAnAlignmentThatThereIsNot) {
  LatentHandle handle;

  EXPECT_EQ(sinew_play(handle.policy, "turn", 0, 7), -1);

  EXPECT_THAT(sinew_error(handle.policy),
              HasSubstr("align: expected one of SINEW_ALIGN_..., found 7"));
}

TEST(CInterface, EncodesAndDecodesWhatItSteps) {
  LatentHandle handle;
  std::vector<double> stepped(4);
  ASSERT_EQ(sinew_latent_width(handle.policy), 6);
  ASSERT_EQ(sinew_encode(handle.policy, &handle.state, nullptr,
                         handle.mean.data(), handle.spread.data(), 6),
            0);
  ASSERT_EQ(sinew_decode(handle.policy, &handle.state, handle.mean.data(), 6,
                         handle.target.data()),
            0);

  ASSERT_EQ(sinew_seek(handle.policy, 0), 0);
  ASSERT_EQ(sinew_step(handle.policy, &handle.state, stepped.data()), 0);

  EXPECT_EQ(handle.target, stepped);
}

TEST(CInterface, SamplesWithoutNoiseByThePriorsMean) {
  LatentHandle handle;
  const double noise[6] = {};
  std::vector<double> sampled(4);
  ASSERT_EQ(sinew_prior(handle.policy, &handle.state, handle.mean.data(),
                        handle.spread.data(), 6),
            0);
  ASSERT_EQ(sinew_decode(handle.policy, &handle.state, handle.mean.data(), 6,
                         handle.target.data()),
            0);

  ASSERT_EQ(
      sinew_sample(handle.policy, &handle.state, noise, 6, sampled.data()), 0);

  EXPECT_EQ(handle.target, sampled);
  EXPECT_GT(handle.spread[0], 0);
}

TEST(CInterface, GivesWhatPriorAndDecoderSee) {
  LatentHandle handle;
  ASSERT_EQ(sinew_self_observation_width(handle.policy), 33);
  std::vector<double> own(33);

  ASSERT_EQ(sinew_self_observation(handle.policy, &handle.state, own.data(),
                                   static_cast<int>(own.size())),
            0);

  EXPECT_FLOAT_EQ(own[0], handle.position[2]);  // the root's height
  EXPECT_EQ(sinew_self_observation(handle.policy, &handle.state, own.data(), 9),
            -1);
  EXPECT_THAT(sinew_error(handle.policy), HasSubstr("room for 33 numbers"));
}

TEST(CInterface, GivesBodiesWherePriorAndDecoderSeeThem) {
  v1::Recipe recipe = bundle::testing::ToyLatentRecipe();
  v1::Observation& observation = *recipe.mutable_task()->mutable_observation();
  observation.clear_blocks();
  observation.add_blocks(v1::Observation::BLOCK_SELF_BODIES);
  observation.add_blocks(v1::Observation::BLOCK_REFERENCE_BODIES);
  LatentHandle handle(recipe, {.self = 73, .observation = 73 + 24 * 5});
  ASSERT_EQ(sinew_self_observation_width(handle.policy), 73);
  std::vector<double> own(73);

  ASSERT_EQ(sinew_self_observation(handle.policy, &handle.state, own.data(),
                                   static_cast<int>(own.size())),
            0);

  EXPECT_FLOAT_EQ(own[0], handle.position[2]);  // the root's height
  // Hips of the front legs: 0.4 m apart.
  EXPECT_NEAR(std::hypot(own[1] - own[4], own[2] - own[5], own[3] - own[6]),
              0.4, 1e-6);
  EXPECT_FLOAT_EQ(own[73 - 5 * 6 + 2], handle.velocity[2]);  // the root's
}

TEST(CInterface, RefusesALatentOfTheWrongSize) {
  LatentHandle handle;
  const double* mean = handle.mean.data();
  double* target = handle.target.data();

  for (const int size : {-1, 0, 5, 7}) {
    EXPECT_EQ(sinew_decode(handle.policy, &handle.state, mean, size, target),
              -1);
    EXPECT_THAT(sinew_error(handle.policy),
                HasSubstr("latent: expected 6 numbers"));
    EXPECT_EQ(sinew_sample(handle.policy, &handle.state, mean, size, target),
              -1);
    EXPECT_EQ(sinew_prior(handle.policy, &handle.state, handle.mean.data(),
                          handle.spread.data(), size),
              -1);
    EXPECT_EQ(sinew_encode(handle.policy, &handle.state, nullptr,
                           handle.mean.data(), handle.spread.data(), size),
              -1);
  }
  EXPECT_EQ(sinew_decode(handle.policy, &handle.state, nullptr, 6, target), -1);
  EXPECT_STREQ(sinew_error(handle.policy),
               "latent: expected a pointer, found NULL");
}

TEST(CInterface, NamesEveryPointerThatIsMissing) {
  LatentHandle handle;
  sinew_runtime* policy = handle.policy;
  const sinew_pose* state = &handle.state;
  double* mean = handle.mean.data();
  double* spread = handle.spread.data();
  double target[4];
  const auto expect = [&](int result, const char* name) {
    EXPECT_EQ(result, -1) << name;
    EXPECT_EQ(sinew_error(policy),
              absl::StrCat(name, ": expected a pointer, found NULL"));
  };

  expect(sinew_self_observation(policy, nullptr, mean, 6), "state");
  expect(sinew_self_observation(policy, state, nullptr, 6), "observation");
  expect(sinew_encode(policy, nullptr, nullptr, mean, spread, 6), "state");
  expect(sinew_encode(policy, state, nullptr, nullptr, spread, 6), "mean");
  expect(sinew_encode(policy, state, nullptr, mean, nullptr, 6), "std");
  expect(sinew_prior(policy, nullptr, mean, spread, 6), "state");
  expect(sinew_prior(policy, state, nullptr, spread, 6), "mean");
  expect(sinew_prior(policy, state, mean, nullptr, 6), "std");
  expect(sinew_decode(policy, nullptr, mean, 6, target), "state");
  expect(sinew_decode(policy, state, mean, 6, nullptr), "target");
  expect(sinew_sample(policy, nullptr, mean, 6, target), "state");
  expect(sinew_sample(policy, state, nullptr, 6, target), "noise");
  expect(sinew_sample(policy, state, mean, 6, nullptr), "target");
}

TEST(CInterface, SaysThatABundleHasNoLatent) {
  const Paths paths;
  sinew_runtime* policy = sinew_open(paths.bundle.c_str(), nullptr, 0);
  ASSERT_NE(policy, nullptr);
  const sinew_pose state = {};
  const double latent[6] = {};
  double target[4];

  EXPECT_EQ(sinew_latent_width(policy), 0);
  EXPECT_EQ(sinew_self_observation_width(policy), 0);
  EXPECT_EQ(sinew_decode(policy, &state, latent, 6, target), -1);
  EXPECT_STREQ(sinew_error(policy), "this bundle has no latent");
  sinew_close(policy);
}

TEST(CInterface, DescribesThePolicy) {
  const Paths paths;
  sinew_runtime* policy = sinew_open(paths.bundle.c_str(), nullptr, 0);
  ASSERT_NE(policy, nullptr);
  double stiffness[4], limit[4];
  sinew_gains(policy, stiffness, nullptr, limit);

  EXPECT_EQ(sinew_joint_count(policy), 4);
  EXPECT_STREQ(sinew_joint_name(policy, 2), "hip_fr");
  EXPECT_EQ(sinew_joint_name(policy, 4), nullptr);
  EXPECT_EQ(stiffness[2], 100);
  EXPECT_EQ(limit[0], 60);
  EXPECT_EQ(sinew_control_hz(policy), 30);
  EXPECT_EQ(sinew_frame_count(policy), 1);
  EXPECT_EQ(sinew_frame_ahead(policy, 0), 1);
  EXPECT_EQ(sinew_foot_count(policy), 2);
  EXPECT_EQ(sinew_needs_torque(policy), 0);
  EXPECT_EQ(sinew_clip_count(policy), 0);
  EXPECT_STREQ(sinew_error(policy), "");
  EXPECT_EQ(sinew_step(policy, nullptr, limit), -1);
  EXPECT_STREQ(sinew_error(policy), "state: expected a pointer, found NULL");
  sinew_close(policy);
}

}  // namespace
}  // namespace sinew::runtime
