#ifndef SINEW_SIM_WORLD_TESTING_TASK_RIG_H_
#define SINEW_SIM_WORLD_TESTING_TASK_RIG_H_

#include <mujoco/mujoco.h>

#include <memory>
#include <vector>

#include "sim/world/fallen_states.h"
#include "sim/world/testing/toy_world.h"
#include "sim/world/tracking_task.h"

namespace sinew::world::testing {

// As the toy's recipe asks for; null if it asks for none. Aborts with a message
// on any error.
std::unique_ptr<const FallenStates> MakeFallenStates(const ToyWorld& toy);

// A task of the toy world with what a rollout thread has, and fallen states if
// the recipe asks for them. Members abort with a message on any error.
struct TaskRig {
  explicit TaskRig(const v1::Recipe& recipe = ToyRecipe(),
                   ToyClips clips = ToyClips::kStanding);

  // At frame `frame` of a clip, as `start` says.
  void Begin(int clip, int frame, const BodyStart& start = {});
  const std::vector<float>& Observe();
  StepResult Step();
  // The physics row of the data.
  std::vector<double> Row() const;
  void SetRow(const std::vector<double>& row);

  ToyWorld toy;
  std::unique_ptr<const FallenStates> fallen;  // may be null
  std::unique_ptr<const TrackingTask> task;
  const mjModel* model;
  character::DataPtr data;
  std::unique_ptr<TrackingTask::Workspace> work;
  Episode episode;
  std::vector<double> previous, target;
  std::vector<float> action, observation;
};

}  // namespace sinew::world::testing

#endif  // SINEW_SIM_WORLD_TESTING_TASK_RIG_H_
