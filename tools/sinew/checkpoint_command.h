#ifndef SINEW_TOOLS_SINEW_CHECKPOINT_COMMAND_H_
#define SINEW_TOOLS_SINEW_CHECKPOINT_COMMAND_H_

#include <CLI/CLI.hpp>

#include "tools/sinew/command.h"

namespace sinew::tools {

// sinew checkpoint serve | list | get | put | alias: the checkpoint role and
// what people do with a store, be it a folder or a service. INVALID_ARGUMENT
// for the names of deploy/checkpoint/stable_bundle.h, which `sinew promote`
// alone gives. See command.h.
void AddCheckpointCommand(CLI::App& app, Action& action);

}  // namespace sinew::tools

#endif  // SINEW_TOOLS_SINEW_CHECKPOINT_COMMAND_H_
