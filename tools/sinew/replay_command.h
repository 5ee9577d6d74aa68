#ifndef SINEW_TOOLS_SINEW_REPLAY_COMMAND_H_
#define SINEW_TOOLS_SINEW_REPLAY_COMMAND_H_

#include <CLI/CLI.hpp>

#include "tools/sinew/command.h"

namespace sinew::tools {

// sinew replay: the table of segments between actors and a learner, as a
// server.
void AddReplayCommand(CLI::App& app, Action& action);

}  // namespace sinew::tools

#endif  // SINEW_TOOLS_SINEW_REPLAY_COMMAND_H_
