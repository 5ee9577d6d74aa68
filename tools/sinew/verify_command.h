#ifndef SINEW_TOOLS_SINEW_VERIFY_COMMAND_H_
#define SINEW_TOOLS_SINEW_VERIFY_COMMAND_H_

#include "tools/sinew/command.h"

namespace sinew::tools {

// `sinew verify BUNDLE`: digests and parts of a bundle, then parity of its
// back ends, as a table.
void AddVerifyCommand(CLI::App& app, Action& action);

}  // namespace sinew::tools

#endif  // SINEW_TOOLS_SINEW_VERIFY_COMMAND_H_
