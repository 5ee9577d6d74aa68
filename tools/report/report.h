#ifndef SINEW_TOOLS_REPORT_REPORT_H_
#define SINEW_TOOLS_REPORT_REPORT_H_

#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "common/stop.h"

namespace sinew::report {

struct ReportOptions {
  std::string run = {};      // run directory
  std::string motions = {};  // library folder; empty: as eval.json says
  std::string clip = {};     // to show in motion; empty: the first
  std::string out = {};      // file; empty: report.html in the run directory
};

// Writes the report of a run: one file, atomically. Whatever the run lacks
// (evaluation, bundle, library, OpenGL), the report says so and has the rest.
// Shown in motion is the bundle that eval.json is about, else RUN/bundle. An
// eval.json of neither RUN/bundle nor RUN/bundle_best is older than they are,
// and left out.
// Returns the file's path.
//
//   sinew train -> RUN/bundle;  sinew eval -> RUN/eval.json;  WriteReport
//
// Thread-safety: uses OpenGL; one call at a time. Blocking: seconds, for
// pictures. Errors: NOT_FOUND (no run there), INVALID_ARGUMENT (no such clip),
// CANCELLED, those of writing.
absl::StatusOr<std::string> WriteReport(const ReportOptions& options,
                                        const StopToken& stop);

}  // namespace sinew::report

#endif  // SINEW_TOOLS_REPORT_REPORT_H_
