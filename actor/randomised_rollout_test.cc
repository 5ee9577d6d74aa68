// Rollouts in which everything is on that may differ from episode to episode.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "actor/rollout.h"
#include "actor/testing/rollout_rig.h"
#include "common/config/recipe.h"
#include "common/digest.h"
#include "sim/world/testing/toy_world.h"

namespace sinew::actor {
namespace {

using testing::RolloutRig;

v1::Recipe RandomisedRecipe() {
  auto recipe = ParseRecipe(
      "task {"
      "  recovery { fallen_share: 0.2 far_share: 0.2 steps: 4"
      "             fallen_states: 2 }"
      "  randomisation { mass: 0.2 friction: 0.4 joint_offset: 0.03 gain: 0.2"
      "                  push_impulse: 3 push_interval: 0.4"
      "                  push_bodies: [\"trunk\", \"leg_fl\"] }"
      "  actuator_model { drives {} }"
      "}",
      "test");
  EXPECT_TRUE(recipe.ok()) << recipe.status();
  return WithDefaults(*recipe);
}

TEST(RandomisedRollout, CutInTwoHalvesIsTheSameRollout) {
  RolloutRig rig(RandomisedRecipe());

  EXPECT_GT(rig.RunWholeAndInHalves(3, 40).episodes_size(), 3);
}

TEST(RandomisedRollout, GivesTheSameBytesAfterOtherWorkAndInAnotherWorker) {
  RolloutRig rig(RandomisedRecipe());
  v1::Order other = rig.TrainOrder(2, 7);
  other.set_first_environment(50);

  rig.ExpectSameBytes(rig.TrainOrder(3, 30), other);
}

TEST(RandomisedRollout, GroupingOfEnvironmentsChangesNothing) {
  RolloutRig rig(RandomisedRecipe());
  const v1::Segment together = rig.Run(rig.TrainOrder(3, 30));
  for (int e = 0; e < 3; ++e) {
    v1::Order order = rig.TrainOrder(1, 30);
    order.set_first_environment(e);

    EXPECT_EQ(SerializeDeterministically(together.end_states(e)),
              SerializeDeterministically(rig.Run(order).end_states(0)));
  }
}

TEST(RandomisedRollout, EvaluationsAreNominalUnlessAskedFor) {
  v1::Recipe recipe = RandomisedRecipe();
  recipe.mutable_task()->clear_randomisation();
  RolloutRig nominal(recipe);
  RolloutRig randomised(RandomisedRecipe());
  recipe = RandomisedRecipe();
  recipe.mutable_task()->mutable_randomisation()->set_in_evaluation(true);
  RolloutRig asked(recipe);
  const auto error = [](RolloutRig& rig) {
    return rig.Run(rig.EvaluationOrder({{1, 0, 10}}))
        .results(0)
        .sum_g_mpjpe_mm();
  };

  EXPECT_EQ(error(nominal), error(randomised));
  EXPECT_NE(error(nominal), error(asked));
}

TEST(RandomisedRollout, AnEvaluationsConditionsAreThoseOfItsStart) {
  v1::Recipe recipe = RandomisedRecipe();
  recipe.mutable_task()->mutable_randomisation()->set_in_evaluation(true);
  RolloutRig rig(recipe);

  const v1::Segment both =
      rig.Run(rig.EvaluationOrder({{1, 0, 10}, {1, 5, 10}}));
  const v1::Segment alone = rig.Run(rig.EvaluationOrder({{1, 5, 10}}));

  EXPECT_EQ(SerializeDeterministically(both.results(1)),
            SerializeDeterministically(alone.results(0)));
}

}  // namespace
}  // namespace sinew::actor
