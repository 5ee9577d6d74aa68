#ifndef SINEW_TOOLS_REPORT_REPRODUCE_H_
#define SINEW_TOOLS_REPORT_REPRODUCE_H_

#include <string>

#include "proto/sinew/v1/motion.pb.h"
#include "tools/report/run_record.h"

namespace sinew::report {

// Commands that make a run again, in order: import, train, eval, report. All
// they write is below runs/again, the library too; what the run began with and
// knows the digest of alone (--init, --primitives, --teacher) is BUNDLE.
//
// There is an import where the library's manifest tells all of it: few files,
// each whole, none left out, blended, or mirrored while others are not. Else
// the commands use the library as it is. Not in a manifest, and so not in the
// import: --align, and what was said of files that do not say it themselves.
//
// `library`: no clips: unknown. `motions`: its folder; empty: unknown. Pure.
Json ReproduceCommands(const RunRecord& run, const v1::MotionLibrary& library,
                       const std::string& motions);

// The word as a shell takes it: quoted where need be. Pure.
std::string ShellWord(const std::string& word);

}  // namespace sinew::report

#endif  // SINEW_TOOLS_REPORT_REPRODUCE_H_
