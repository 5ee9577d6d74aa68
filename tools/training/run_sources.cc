#include "tools/training/run_sources.h"

#include "absl/strings/str_cat.h"
#include "common/logging.h"
#include "common/status_macros.h"
#include "deploy/bundle/run_export.h"

namespace sinew::tools {
namespace {

absl::Status CheckSameTeacher(const v1::RunInputs& before,
                              const v1::RunInputs::Source& teacher) {
  for (const v1::RunInputs::Source& source : before.sources()) {
    if (source.bundle().role() != "teacher") continue;
    const std::string& expected = source.bundle().manifest_sha256();
    const std::string& found = teacher.bundle().manifest_sha256();
    if (expected == found) return absl::OkStatus();
    return absl::FailedPreconditionError(
        absl::StrCat("--teacher: expected the bundle that the run was started "
                     "with (manifest_sha256 ",
                     expected, "), found another (", found,
                     "); give the same, or another --run"));
  }
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<std::vector<v1::RunInputs::Source>> RunSources(
    const std::string& run, bool resumed, const InitialPolicy& initial,
    const std::optional<RunTeacher>& teacher) {
  if (resumed) {
    const auto before = bundle::ReadRunInputs(run);
    if (before.ok()) {
      if (teacher) {
        SINEW_RETURN_IF_ERROR(CheckSameTeacher(*before, teacher->source));
      }
      return std::vector<v1::RunInputs::Source>(before->sources().begin(),
                                                before->sources().end());
    }
    LogWarning("what the run began with cannot be read",
               {{"reason", before.status().message()}});
  }
  SINEW_ASSIGN_OR_RETURN(std::vector<v1::RunInputs::Source> sources,
                         InitialSources(initial));
  if (teacher) sources.push_back(teacher->source);
  return sources;
}

}  // namespace sinew::tools
