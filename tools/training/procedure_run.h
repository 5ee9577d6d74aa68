#ifndef SINEW_TOOLS_TRAINING_PROCEDURE_RUN_H_
#define SINEW_TOOLS_TRAINING_PROCEDURE_RUN_H_

#include "absl/status/status.h"
#include "common/stop.h"
#include "tools/training/procedure_steps.h"
#include "tools/training/training_run.h"

namespace sinew::tools {

// Fallen starts that a stage which learns to get up is evaluated from.
inline constexpr int kProcedureFallenStarts = 256;

// Starts or resumes the procedure of a recipe (learner/procedure/procedure.h)
// in a run directory:
//
//   while there is a next stage:
//     decide it from those that have finished    -> procedure.json
//     train it in RUN/stages/NN_NAME, from the bundle of another
//     evaluate its bundle on the whole library   -> NN_NAME/eval.json
//     note which clips it fails, and of a stage that starts on the floor how
//     many of kProcedureFallenStarts get up      -> procedure.json
//   bundle and eval.json of the stage that it came to -> RUN
//
// The last comes before a single primitive that is there for comparison, which
// has no part in it.
//
// What is interrupted anywhere, by a kill too, goes on with the next call and
// ends with the same weights. options.minutes and iterations (or the recipe's)
// bound all stages together and leave the rest to the next call.
//
// Blocking: until the end, for hours. Errors: INVALID_ARGUMENT: the recipe of a
// stage, options that a procedure does not know (migrate_library, primitives,
// replay and checkpoints elsewhere), another recipe than before;
// FAILED_PRECONDITION: another library or character than before, a locked
// folder; DATA_LOSS: procedure.json; those of the steps, after which it may be
// resumed.
absl::Status RunProcedure(const TrainingRun::Options& options,
                          const ProcedureSteps& steps, const StopToken& stop);

}  // namespace sinew::tools

#endif  // SINEW_TOOLS_TRAINING_PROCEDURE_RUN_H_
