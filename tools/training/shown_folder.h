#ifndef SINEW_TOOLS_TRAINING_SHOWN_FOLDER_H_
#define SINEW_TOOLS_TRAINING_SHOWN_FOLDER_H_

#include <string>

#include "absl/status/statusor.h"

namespace sinew::tools {

// Where what is to be shown of a run is: in the folder itself or, of a
// procedure, in that of the newest stage that has some, or else of the newest.
//
// Thread-safety: any thread. Blocking: on the disk. Errors: none; a record that
// cannot be read says nothing, and the run itself is shown.
std::string FolderWithState(const std::string& run);  // a training state
std::string FolderWithRows(const std::string& run);   // rows of metrics.jsonl

// The folder of the run whose policy is exported: `run` itself or, of a
// procedure that is over, the stage that it came to (learner::ResultStage), for
// which nobody waits for a single primitive beside it.
//
// Thread-safety: any thread. Blocking: on the disk. Errors:
// FAILED_PRECONDITION: the procedure is not over, naming the stage to export
// instead; DATA_LOSS: its record is damaged.
absl::StatusOr<std::string> FolderToExport(const std::string& run);

}  // namespace sinew::tools

#endif  // SINEW_TOOLS_TRAINING_SHOWN_FOLDER_H_
