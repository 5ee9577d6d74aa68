#include "tools/training/make_learner.h"

#include <utility>

#include "common/status_macros.h"
#include "learner/distillation/distillation_learner.h"
#include "learner/ppo/ppo_learner.h"

namespace sinew::tools {
namespace {

absl::StatusOr<std::unique_ptr<learner::Learner>> MakePpo(
    const v1::Recipe& recipe, const TaskSetup& setup, int ranks,
    const std::optional<InitialPolicy>& initial) {
  SINEW_ASSIGN_OR_RETURN(
      std::unique_ptr<learner::PpoLearner> learner,
      learner::PpoLearner::Create(
          recipe, {.observation_width = setup.observation_width,
                   .self_observation_width = setup.self_observation_width,
                   .action_width = setup.action_width,
                   .ranks = ranks,
                   .mirror = setup.mirror}));
  if (initial) {
    SINEW_RETURN_IF_ERROR(BeginWith(*initial, recipe, setup, *learner));
  }
  return learner;
}

absl::StatusOr<std::unique_ptr<learner::Learner>> MakeDistillation(
    const v1::Recipe& recipe, const TaskSetup& setup, int ranks,
    const RunTeacher& teacher, const std::optional<InitialPolicy>& initial) {
  SINEW_ASSIGN_OR_RETURN(
      std::unique_ptr<learner::DistillationLearner> learner,
      learner::DistillationLearner::Create(
          recipe, {.observation_width = setup.observation_width,
                   .self_observation_width = setup.self_observation_width,
                   .action_width = setup.action_width,
                   .ranks = ranks,
                   .annotator = teacher.annotator.get(),
                   .layout = setup.layout,
                   .action_scale = setup.action_scales,
                   .mirror = setup.mirror,
                   .add_graphs = teacher.add_graph}));
  if (initial) {
    SINEW_RETURN_IF_ERROR(BeginWithInit(*initial, recipe, setup, *learner));
  }
  return learner;
}

}  // namespace

absl::StatusOr<std::unique_ptr<learner::Learner>> MakeLearner(
    const v1::Recipe& recipe, const TaskSetup& setup, int ranks,
    const std::optional<RunTeacher>& teacher,
    const std::optional<InitialPolicy>& initial) {
  return teacher ? MakeDistillation(recipe, setup, ranks, *teacher, initial)
                 : MakePpo(recipe, setup, ranks, initial);
}

}  // namespace sinew::tools
