#ifndef SINEW_TOOLS_TRAINING_PROCEDURE_INPUTS_H_
#define SINEW_TOOLS_TRAINING_PROCEDURE_INPUTS_H_

#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "proto/sinew/v1/recipe.pb.h"
#include "tools/training/procedure_record.h"
#include "tools/training/task_setup.h"

namespace sinew::tools {

// What a procedure is about.
struct ProcedureInputs {
  std::vector<std::string> clips;       // names of all, in the library's order
  std::vector<std::string> trained_on;  // of those that starts are drawn from
  ProcedureRecord record;               // of a procedure that begins
};

// `recipe` has its defaults filled; `setup` is that of its first stage. Pure.
// INVALID_ARGUMENT: no clip of the library is trained on.
absl::StatusOr<ProcedureInputs> MakeProcedureInputs(const v1::Recipe& recipe,
                                                    const TaskSetup& setup);

// FAILED_PRECONDITION naming the run's folder and what differs between the
// record that lies there and that of a procedure of the same inputs.
absl::Status CheckSameInputs(const ProcedureRecord& found,
                             const ProcedureRecord& expected,
                             const std::string& run);

}  // namespace sinew::tools

#endif  // SINEW_TOOLS_TRAINING_PROCEDURE_INPUTS_H_
