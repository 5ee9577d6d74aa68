#include "tools/training/run_sources.h"

#include <algorithm>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "common/logging.h"
#include "common/status_macros.h"
#include "deploy/bundle/run_export.h"

namespace sinew::tools {
namespace {

using Sources = std::vector<v1::RunInputs::Source>;

// Digests of the teachers among them; labels do not depend on their order.
std::string Teachers(const Sources& sources) {
  std::vector<std::string> digests;
  for (const v1::RunInputs::Source& source : sources) {
    if (source.bundle().role() != "teacher") continue;
    digests.push_back(source.bundle().manifest_sha256());
  }
  std::sort(digests.begin(), digests.end());
  return absl::StrJoin(digests, ", ");
}

absl::Status CheckSameTeacher(const Sources& before,
                              const RunTeacher& teacher) {
  const std::string expected = Teachers(before);
  const std::string found = Teachers(teacher.sources);
  if (expected.empty() || expected == found) return absl::OkStatus();
  return absl::FailedPreconditionError(
      absl::StrCat("--teacher: expected what the run was started with "
                   "(manifest_sha256 ",
                   expected, "), found another (", found,
                   "); give the same, or another --run"));
}

// What was said so far; unset where it cannot be read.
std::optional<Sources> SourcesBefore(const std::string& run,
                                     const std::optional<Sources>& moved) {
  if (moved) return moved;
  const auto inputs = bundle::ReadRunInputs(run);
  if (inputs.ok()) {
    return Sources(inputs->sources().begin(), inputs->sources().end());
  }
  LogWarning("what the run began with cannot be read",
             {{"reason", inputs.status().message()}});
  return std::nullopt;
}

}  // namespace

absl::StatusOr<Sources> RunSources(const std::string& run, bool resumed,
                                   const std::optional<Sources>& moved,
                                   const InitialPolicy& initial,
                                   const std::optional<RunTeacher>& teacher) {
  if (resumed) {
    const std::optional<Sources> before = SourcesBefore(run, moved);
    if (before && teacher) {
      SINEW_RETURN_IF_ERROR(CheckSameTeacher(*before, *teacher));
    }
    if (before) return *before;
  }
  SINEW_ASSIGN_OR_RETURN(Sources sources, InitialSources(initial));
  if (teacher) {
    sources.insert(sources.end(), teacher->sources.begin(),
                   teacher->sources.end());
  }
  return sources;
}

}  // namespace sinew::tools
