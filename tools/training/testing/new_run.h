#ifndef SINEW_TOOLS_TRAINING_TESTING_NEW_RUN_H_
#define SINEW_TOOLS_TRAINING_TESTING_NEW_RUN_H_

#include <memory>

#include "absl/status/status.h"
#include "common/files.h"
#include "learner/ppo/ppo_learner.h"
#include "proto/sinew/v1/recipe.pb.h"
#include "sim/world/testing/toy_world.h"
#include "tools/training/initial_policy.h"
#include "tools/training/task_setup.h"

namespace sinew::tools::testing {

// A run of the toy world, before its first iteration.
struct NewRun {
  explicit NewRun(const v1::Recipe& of_recipe) : recipe(of_recipe) {
    const world::testing::ToyWorld toy = world::testing::MakeToyWorld(recipe);
    setup = *SetUpTask(recipe, JoinPath(toy.folder, "character.textproto"),
                       toy.library_folder);
    learner = *learner::PpoLearner::Create(
        recipe, {.observation_width = setup.observation_width,
                 .self_observation_width = setup.self_observation_width,
                 .action_width = setup.action_width});
  }
  absl::Status Begin(const InitialPolicy& policy) const {
    return BeginWith(policy, recipe, setup, *learner);
  }

  v1::Recipe recipe;
  TaskSetup setup;
  std::unique_ptr<learner::PpoLearner> learner;
};

}  // namespace sinew::tools::testing

#endif  // SINEW_TOOLS_TRAINING_TESTING_NEW_RUN_H_
