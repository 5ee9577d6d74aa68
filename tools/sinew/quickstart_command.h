#ifndef SINEW_TOOLS_SINEW_QUICKSTART_COMMAND_H_
#define SINEW_TOOLS_SINEW_QUICKSTART_COMMAND_H_

#include "tools/sinew/command.h"

namespace sinew::tools {

// `sinew quickstart`: imports a real clip, trains a policy on it, evaluates the
// bundle and writes the report, all in one folder, by running the commands a
// user would type, each of which it prints. Run again, it goes on where it was.
void AddQuickstartCommand(CLI::App& app, Action& action);

}  // namespace sinew::tools

#endif  // SINEW_TOOLS_SINEW_QUICKSTART_COMMAND_H_
