#ifndef SINEW_TOOLS_TRAINING_MAKE_LEARNER_H_
#define SINEW_TOOLS_TRAINING_MAKE_LEARNER_H_

#include <memory>
#include <optional>

#include "absl/status/statusor.h"
#include "learner/learner.h"
#include "proto/sinew/v1/recipe.pb.h"
#include "tools/training/initial_policy.h"
#include "tools/training/run_teacher.h"
#include "tools/training/task_setup.h"

namespace sinew::tools {

// The learner that a recipe (defaults filled) asks for: distillation, which
// borrows the teacher, or PPO. `initial`, where there is one, is put into it: a
// run without states begins with that.
//
// Thread-safety: a function. Blocking: a fraction of a second; reads bundles.
// Errors: those of the learners' Create and of BeginWith.
absl::StatusOr<std::unique_ptr<learner::Learner>> MakeLearner(
    const v1::Recipe& recipe, const TaskSetup& setup, int ranks,
    const std::optional<RunTeacher>& teacher,
    const std::optional<InitialPolicy>& initial);

}  // namespace sinew::tools

#endif  // SINEW_TOOLS_TRAINING_MAKE_LEARNER_H_
