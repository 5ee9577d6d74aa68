// A body that actions alone move, moved as in training: by the code that
// actors use, which has a reference as well.

#include "tools/sampling/free_body.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/types/span.h"
#include "common/config/recipe.h"
#include "common/random/philox.h"
#include "deploy/bundle/bundle.h"
#include "deploy/bundle/testing/toy_latent.h"
#include "proto/sinew/v1/recipe.pb.h"
#include "sim/world/testing/task_rig.h"

namespace sinew::sampling {
namespace {

using ::testing::Each;
using ::testing::Not;

constexpr int kJoints = 4;
// Of the toy: 33 of joint space, then previous target and contacts of 2 feet;
// 35 of the reference behind them.
constexpr int kPreviousTarget = 33;
constexpr bundle::testing::LatentWidths kWidths = {.self = 39,
                                                   .observation = 74};

// All of the body's own blocks, the goal behind them; `task`: the rest of it.
v1::Recipe MakeRecipe(const std::string& task) {
  return WithDefaults(
      ParseRecipe(absl::StrCat("task { observation { blocks: ["
                               "BLOCK_SELF_JOINT_SPACE, BLOCK_PREVIOUS_TARGET, "
                               "BLOCK_SELF_CONTACT, "
                               "BLOCK_REFERENCE_DIFFERENCE] } ",
                               task, " }"),
                  "test")
          .value());
}

// A body of training, and one of its bundle that begins in the same state.
struct Bodies {
  explicit Bodies(const std::string& task)
      : trained(MakeRecipe(task)),
        law(BodyLaw::Create(bundle::ReadBundle(bundle::testing::WriteToyLatent(
                                                   trained.toy, kWidths))
                                .value(),
                            kWidths.self)
                .value()),
        body(law) {
    trained.Begin(/*clip=*/0, /*frame=*/5);
    Start();
  }

  // Where the trained one is.
  void Start() {
    body.Start({trained.data->qpos, static_cast<size_t>(trained.model->nq)},
               {trained.data->qvel, static_cast<size_t>(trained.model->nv)});
  }
  std::vector<float> Observe() {
    std::vector<float> observation(kWidths.self);
    body.Observe(absl::MakeSpan(observation));
    return observation;
  }
  std::vector<float> ObservePreviousTarget() {
    const std::vector<float> all = Observe();
    return {all.begin() + kPreviousTarget,
            all.begin() + kPreviousTarget + kJoints};
  }

  world::testing::TaskRig trained;
  std::shared_ptr<const BodyLaw> law;
  FreeBody body;
};

struct Case {
  std::string name, task;
};

class FreeBodyOf : public ::testing::TestWithParam<Case> {};

TEST_P(FreeBodyOf, MovesBitForBitAsInTraining) {
  Bodies bodies(GetParam().task);
  world::testing::TaskRig& trained = bodies.trained;
  for (int step = 0; step < 24; ++step) {
    SCOPED_TRACE(step);
    const std::vector<float>& seen = trained.Observe();
    ASSERT_EQ(bodies.Observe(),
              std::vector<float>(seen.begin(), seen.begin() + kWidths.self));
    FillNormal({.seed = 1, .step = static_cast<uint64_t>(step)},
               absl::MakeSpan(trained.action));

    ASSERT_FALSE(trained.Step().diverged);
    ASSERT_TRUE(bodies.body.Step(trained.action));

    const absl::Span<const double> qpos = bodies.body.qpos();
    ASSERT_EQ(std::vector<double>(qpos.begin(), qpos.end()),
              std::vector<double>(trained.data->qpos,
                                  trained.data->qpos + trained.model->nq));
    ASSERT_EQ(bodies.body.state().joint_velocity,
              trained.work->body.joint_velocity);
  }
}

// Drives that leave little of the torque.
constexpr char kDrives[] =
    "actuator_model { drives { static_friction: 2 max_torque: 15 "
    "limit_velocity: 2 max_velocity: 10 } }";

INSTANTIATE_TEST_SUITE_P(
    Laws, FreeBodyOf,
    ::testing::Values(
        Case{"Absolute", "action { placement: PLACEMENT_ABSOLUTE }"},
        Case{"AroundCurrent", "action { placement: PLACEMENT_AROUND_CURRENT }"},
        Case{"Ramp", "action { placement: PLACEMENT_ABSOLUTE ramp: true }"},
        Case{
            "AbsoluteWithDrives",
            absl::StrCat("action { placement: PLACEMENT_ABSOLUTE } ", kDrives)},
        Case{"AroundCurrentWithDrivesAndRamp",
             absl::StrCat(
                 "action { placement: PLACEMENT_AROUND_CURRENT ramp: true } ",
                 kDrives)}),
    [](const auto& info) { return info.param.name; });

TEST(FreeBody, BeginsWithThePreviousTargetWhereTheJointsAre) {
  Bodies bodies("action { placement: PLACEMENT_ABSOLUTE }");
  // Legs swing at the start, so that it is not the default pose.
  EXPECT_THAT(bodies.body.state().joint_position, Not(Each(0.0)));

  EXPECT_THAT(bodies.ObservePreviousTarget(), Each(0.0F));
  ASSERT_TRUE(bodies.body.Step(std::vector<float>(kJoints, 1.0F)));
  EXPECT_THAT(bodies.ObservePreviousTarget(), Not(Each(0.0F)));
  bodies.Start();

  EXPECT_THAT(bodies.ObservePreviousTarget(), Each(0.0F));
}

}  // namespace
}  // namespace sinew::sampling
