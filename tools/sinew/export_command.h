#ifndef SINEW_TOOLS_SINEW_EXPORT_COMMAND_H_
#define SINEW_TOOLS_SINEW_EXPORT_COMMAND_H_

#include "tools/sinew/command.h"

namespace sinew::tools {

// `sinew export --run RUN --out BUNDLE [--best]`: a bundle from a run directory
// alone: of its newest saved state, or of the best evaluated policy. Of a
// procedure that is over: the same of the stage that it came to.
//
// `sinew export --run RUN --state FOLDER`: what another machine needs to train
// on (tools/training/compact_state.h).
//
// With `--checkpoint STORE`: of a learner whose states are there.
void AddExportCommand(CLI::App& app, Action& action);

}  // namespace sinew::tools

#endif  // SINEW_TOOLS_SINEW_EXPORT_COMMAND_H_
