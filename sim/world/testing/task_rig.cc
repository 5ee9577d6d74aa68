#include "sim/world/testing/task_rig.h"

namespace sinew::world::testing {

std::unique_ptr<const FallenStates> MakeFallenStates(const ToyWorld& toy) {
  return FallenStates::MakeFor(*toy.character, toy.recipe).value();
}

TaskRig::TaskRig(const v1::Recipe& recipe, ToyClips clips)
    : toy(MakeToyWorld(recipe, clips)), fallen(MakeFallenStates(toy)) {
  task = TrackingTask::Create(toy.recipe, *toy.character, *toy.library,
                              fallen.get())
             .value();
  model = toy.character->model();
  data.reset(mj_makeData(model));
  work = task->MakeWorkspace();
  previous.resize(task->action_width());
  target.resize(task->action_width());
  action.resize(task->action_width());
  observation.resize(task->observation_width());
}

void TaskRig::Begin(int clip, int frame, const BodyStart& start) {
  episode = {.clip = clip, .start_frame = frame};
  task->Begin(start, nullptr, data.get(), &episode, absl::MakeSpan(previous),
              work.get());
}

const std::vector<float>& TaskRig::Observe() {
  task->Observe(data.get(), episode, previous, absl::MakeSpan(observation),
                work.get());
  return observation;
}

StepResult TaskRig::Step() {
  task->Target(data.get(), episode, action, absl::MakeSpan(target), work.get());
  return task->Step(data.get(), target, &episode, absl::MakeSpan(previous),
                    work.get());
}

std::vector<double> TaskRig::Row() const {
  std::vector<double> row(task->state_size());
  mj_getState(model, data.get(), row.data(), mjSTATE_INTEGRATION);
  return row;
}

void TaskRig::SetRow(const std::vector<double>& row) {
  mj_setState(model, data.get(), row.data(), mjSTATE_INTEGRATION);
}

}  // namespace sinew::world::testing
