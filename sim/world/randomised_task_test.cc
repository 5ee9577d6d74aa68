// The tracking task under conditions that differ from the nominal ones.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "common/config/recipe.h"
#include "common/testing/allocation_count.h"
#include "sim/world/testing/task_rig.h"

namespace sinew::world {
namespace {

using testing::TaskRig;

v1::Recipe RandomisedRecipe(const std::string& text) {
  auto recipe = ParseRecipe("task { randomisation { " + text + " } }", "test");
  EXPECT_TRUE(recipe.ok()) << recipe.status();
  return WithDefaults(*recipe);
}

// A rig under the conditions of an episode.
struct RandomisedRig : TaskRig {
  explicit RandomisedRig(const std::string& text)
      : TaskRig(RandomisedRecipe(text)), conditions(task->MakeConditions()) {
    task->DrawConditions({.seed = 3, .environment = 1}, &conditions,
                         work.get());
  }
  StepResult StepUnder(const Conditions* under) {
    task->Target(data.get(), episode, action, absl::MakeSpan(target),
                 work.get(), under);
    return task->Step(data.get(), target, &episode, absl::MakeSpan(previous),
                      work.get(), under);
  }
  std::vector<float> ObserveUnder(const Conditions* under) {
    task->Observe(data.get(), episode, previous, absl::MakeSpan(observation),
                  work.get(), under);
    return observation;
  }
  // Linear momentum, kg m/s.
  std::vector<double> Momentum() {
    mj_forward(model, data.get());
    mj_subtreeVel(model, data.get());
    std::vector<double> momentum(3);
    mju_scl(momentum.data(), data->subtree_linvel + 3,
            model->body_subtreemass[1], 3);
    return momentum;
  }

  Conditions conditions;
};

TEST(RandomisedTask, ObservesJointsWithTheirOffsets) {
  RandomisedRig rig("joint_offset: 0.1");
  rig.Begin(0, 3);
  const std::vector<float> truth = rig.ObserveUnder(nullptr);
  const std::vector<float> seen = rig.ObserveUnder(&rig.conditions);

  const std::vector<std::string> names = rig.task->ObservationNames();
  int moved = 0;
  for (size_t i = 0; i < names.size(); ++i) {
    double expected = 0;
    for (int j = 0; j < 4; ++j) {
      const std::string& joint = rig.toy.character->joints()[j].name;
      if (names[i] == "self/joint_position/" + joint) {
        expected = rig.conditions.joint_offset[j];
      } else if (names[i] == "reference+1/joint_position/" + joint) {
        expected = -rig.conditions.joint_offset[j];
      }
    }
    if (expected != 0) ++moved;
    EXPECT_NEAR(seen[i] - truth[i], expected, 1e-6) << names[i];
  }
  EXPECT_EQ(moved, 8);
  EXPECT_GT(std::abs(rig.conditions.joint_offset[0]), 1e-3);
}

TEST(RandomisedTask, PlacesTargetsAroundTheMeasuredJoints) {
  v1::Recipe recipe = RandomisedRecipe("joint_offset: 0.1");
  recipe.mutable_task()->mutable_action()->set_placement(
      v1::Action::PLACEMENT_AROUND_CURRENT);
  TaskRig rig(recipe);
  Conditions conditions = rig.task->MakeConditions();
  rig.task->DrawConditions({.seed = 3}, &conditions, rig.work.get());
  rig.Begin(0, 3);

  rig.task->Target(rig.data.get(), rig.episode, rig.action,
                   absl::MakeSpan(rig.target), rig.work.get(), &conditions);

  for (int j = 0; j < 4; ++j) {
    const auto& joint = rig.toy.character->joints()[j];
    EXPECT_NEAR(rig.target[j],
                rig.data->qpos[joint.qpos_address] + conditions.joint_offset[j],
                1e-12);
  }
}

TEST(RandomisedTask, BeginsWithAPreviousTargetWhereTheEncodersSayTheJointsAre) {
  v1::Recipe recipe = RandomisedRecipe("joint_offset: 0.1");
  recipe.mutable_task()->mutable_action()->set_placement(
      v1::Action::PLACEMENT_ABSOLUTE);
  recipe.mutable_task()->mutable_recovery()->set_fallen_share(0.5);
  recipe.mutable_task()->mutable_recovery()->set_fallen_states(1);
  TaskRig rig(WithDefaults(recipe));
  Conditions conditions = rig.task->MakeConditions();
  rig.task->DrawConditions({.seed = 3}, &conditions, rig.work.get());
  const BodyStart starts[] = {
      {}, {.kind = v1::START_KIND_FALLEN, .recovery_steps = 4}};

  for (const BodyStart& start : starts) {
    rig.episode = {.clip = 0, .start_frame = 3};
    rig.task->Begin(start, /*noise=*/nullptr, rig.data.get(), &rig.episode,
                    absl::MakeSpan(rig.previous), rig.work.get(), &conditions);
    for (int j = 0; j < 4; ++j) {
      const auto& joint = rig.toy.character->joints()[j];
      EXPECT_NE(conditions.joint_offset[j], 0);
      EXPECT_NEAR(
          rig.previous[j],
          rig.data->qpos[joint.qpos_address] + conditions.joint_offset[j],
          1e-12);
    }
  }
}

TEST(RandomisedTask, PushesChangeTheMomentumByTheirImpulseAndLeaveNoForce) {
  const std::string pushed_always =
      "push_impulse: 6 push_interval: 0.1 push_seconds: 0.1 "
      "push_bodies: \"trunk\"";
  RandomisedRig pushed(pushed_always), alone(pushed_always);
  pushed.Begin(2, 0);  // airborne
  alone.Begin(2, 0);
  const Push push =
      pushed.task->randomisation().PushAt(pushed.conditions, /*step=*/0);
  ASSERT_EQ(push.body, 1);

  pushed.StepUnder(&pushed.conditions);
  alone.StepUnder(nullptr);

  for (int i = 0; i < 6 * pushed.model->nbody; ++i) {
    EXPECT_EQ(pushed.data->xfrc_applied[i], 0);
  }
  const std::vector<double> with = pushed.Momentum(),
                            without = alone.Momentum();
  // Euler steps of a body that tumbles keep momentum up to a little.
  const double impulse = mju_norm3(push.force) / 30;
  ASSERT_GT(impulse, 0.01);
  for (int i = 0; i < 3; ++i) {
    EXPECT_NEAR(with[i] - without[i], push.force[i] / 30, 0.05 * impulse) << i;
  }
}

TEST(RandomisedTask, OfNoWidthIsTheNominalTask) {
  RandomisedRig randomised("mass: 0.1"), nominal("mass: 0.1");
  randomised.Begin(0, 3);
  nominal.Begin(0, 3);
  Conditions none = randomised.task->MakeConditions();
  randomised.work->variant->Compute(&none);
  for (int i = 0; i < 6; ++i) {
    EXPECT_NEAR(randomised.StepUnder(&none).reward,
                nominal.StepUnder(nullptr).reward, 1e-6);
  }
  const std::vector<double> found = randomised.Row(), expected = nominal.Row();
  for (size_t i = 0; i < found.size(); ++i) {
    EXPECT_NEAR(found[i], expected[i], 1e-6 * (1 + std::abs(expected[i]))) << i;
  }
}

TEST(RandomisedTask, MassesAndFrictionAndGainsMatter) {
  for (const char* text : {"mass: 0.5", "friction: 0.9", "gain: 0.5"}) {
    RandomisedRig randomised(text), nominal(text);
    randomised.Begin(0, 3);
    nominal.Begin(0, 3);
    for (int i = 0; i < 8; ++i) {
      randomised.StepUnder(&randomised.conditions);
      nominal.StepUnder(nullptr);
    }
    EXPECT_NE(randomised.Row(), nominal.Row()) << text;
  }
}

TEST(RandomisedTask, StepsDoNotAllocate) {
  RandomisedRig rig(
      "mass: 0.1 friction: 0.3 joint_offset: 0.02 gain: 0.1 push_impulse: 2 "
      "push_bodies: \"trunk\"");
  const int64_t before = sinew::testing::AllocationCount();

  for (uint64_t episode = 1; episode < 4; ++episode) {
    rig.task->DrawConditions({.seed = 3, .episode = episode}, &rig.conditions,
                             rig.work.get());
    rig.Begin(1, 0);
    for (int i = 0; i < 4; ++i) {
      rig.task->Observe(rig.data.get(), rig.episode, rig.previous,
                        absl::MakeSpan(rig.observation), rig.work.get(),
                        &rig.conditions);
      rig.StepUnder(&rig.conditions);
    }
  }

  EXPECT_EQ(sinew::testing::AllocationCount() - before, 0);
}

}  // namespace
}  // namespace sinew::world
