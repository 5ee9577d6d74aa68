#ifndef SINEW_TOOLS_TRAINING_PROCEDURE_INPUTS_H_
#define SINEW_TOOLS_TRAINING_PROCEDURE_INPUTS_H_

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "learner/procedure/procedure.h"
#include "proto/sinew/v1/motion.pb.h"
#include "proto/sinew/v1/recipe.pb.h"
#include "tools/training/procedure_record.h"
#include "tools/training/task_setup.h"

namespace sinew::tools {

// What a procedure is about.
struct ProcedureInputs {
  std::vector<std::string> clips;       // names of all, in the library's order
  std::vector<std::string> trained_on;  // of those that starts are drawn from
  ProcedureRecord record;               // of a procedure that begins
  absl::Status clean;                   // CheckClean: whether it may
};

// `recipe` has its defaults filled; `setup` is that of one of its stages;
// `init_sha256` is of the manifest of the bundle that --init names, or empty.
// Pure.
ProcedureInputs MakeProcedureInputs(const v1::Recipe& recipe,
                                    const TaskSetup& setup,
                                    const std::string& init_sha256);

// Whether a procedure may begin on the library: FAILED_PRECONDITION naming the
// first clip whose figures or length are beyond the import's limits
// (sim/import/quality_gate.h). One that has begun goes on as it is. Pure.
absl::Status CheckClean(const v1::MotionLibrary& library);

// What the import of the library in the folder `motions`, of `clips` clips, has
// turned away, and why; unset where it has no report. Logs a warning above a
// tenth of all clips. Blocks on the disk. INVALID_ARGUMENT: a report that is
// none.
absl::StatusOr<std::optional<std::map<std::string, std::string>>> CleanedAway(
    const std::string& motions, int clips);

// FAILED_PRECONDITION naming the run's folder and what differs between the
// record that lies there and that of a procedure of the same inputs. What
// --init named counts until the first stage has ended.
absl::Status CheckSameInputs(const ProcedureRecord& found,
                             const ProcedureRecord& expected,
                             const std::string& run);

// "stages/03_primitive_1_hard": folder of a stage, below the run's.
std::string StageDirectory(const learner::Stage& stage, int index);

// DATA_LOSS naming `source` and the stage unless every stage on record follows
// from those before it. Pure.
absl::Status CheckFollows(const ProcedureRecord& record,
                          const v1::Procedure& procedure,
                          const std::vector<std::string>& trained_on,
                          const std::string& source);

// FAILED_PRECONDITION if the library in the folder `motions` is not the one of
// the record any more. Blocks on the disk.
absl::Status CheckSameLibrary(const ProcedureRecord& record,
                              const std::string& motions);

}  // namespace sinew::tools

#endif  // SINEW_TOOLS_TRAINING_PROCEDURE_INPUTS_H_
