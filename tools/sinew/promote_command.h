#ifndef SINEW_TOOLS_SINEW_PROMOTE_COMMAND_H_
#define SINEW_TOOLS_SINEW_PROMOTE_COMMAND_H_

#include "tools/sinew/command.h"

namespace sinew::tools {

// `sinew promote --store STORE --bundle DIR --motions LIB`: makes a bundle the
// stable one if it is no worse than the one that is; `--rollback` makes the
// bundle before it the stable one again. FAILED_PRECONDITION: refused.
void AddPromoteCommand(CLI::App& app, Action& action);

}  // namespace sinew::tools

#endif  // SINEW_TOOLS_SINEW_PROMOTE_COMMAND_H_
