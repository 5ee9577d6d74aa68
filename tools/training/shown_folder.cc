#include "tools/training/shown_folder.h"

#include <vector>

#include "absl/strings/str_cat.h"
#include "common/files.h"
#include "common/status_macros.h"
#include "learner/procedure/procedure.h"
#include "tools/training/procedure_record.h"
#include "tools/training/run_folder.h"

namespace sinew::tools {
namespace {

// The newest stage that `holds`, or else the newest.
std::string ShownFolder(const std::string& run,
                        bool (*holds)(const std::string& folder)) {
  const std::string file = RunFolder::ProcedureOf(run);
  const auto text = ReadFile(file);
  if (!text.ok()) return run;
  const auto record = ParseProcedure(*text, file);
  if (!record.ok() || record->stages.empty()) return run;
  for (auto it = record->stages.rbegin(); it != record->stages.rend(); ++it) {
    std::string folder = JoinPath(run, it->directory);
    if (holds(folder)) return folder;
  }
  return JoinPath(run, record->stages.back().directory);
}

}  // namespace

std::string FolderWithState(const std::string& run) {
  return ShownFolder(run, RunFolder::HasState);
}

std::string FolderWithRows(const std::string& run) {
  return ShownFolder(run, [](const std::string& folder) {
    return FileSize(RunFolder::MetricsOf(folder)).value_or(0) > 0;
  });
}

absl::StatusOr<std::string> FolderToExport(const std::string& run) {
  const std::string file = RunFolder::ProcedureOf(run);
  if (!FileExists(file)) return run;
  SINEW_ASSIGN_OR_RETURN(const std::string text, ReadFile(file));
  SINEW_ASSIGN_OR_RETURN(const ProcedureRecord record,
                         ParseProcedure(text, file));
  const std::vector<learner::FinishedStage> finished = record.Finished();
  if (record.Decided() && !finished.empty()) {
    return JoinPath(run,
                    record.stages[learner::ResultStage(finished)].directory);
  }
  return absl::FailedPreconditionError(absl::StrCat(
      run,
      ": expected a run, or a procedure that is over, found one that is not "
      "(",
      finished.size(), " stages have ended); export a stage of it: --run ",
      FolderWithState(run)));
}

}  // namespace sinew::tools
