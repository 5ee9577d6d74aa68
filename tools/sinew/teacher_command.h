#ifndef SINEW_TOOLS_SINEW_TEACHER_COMMAND_H_
#define SINEW_TOOLS_SINEW_TEACHER_COMMAND_H_

#include <CLI/CLI.hpp>

#include "tools/sinew/command.h"

namespace sinew::tools {

// sinew teacher: a bundle's policy as a batched annotator, as a server. See
// command.h.
void AddTeacherCommand(CLI::App& app, Action& action);

}  // namespace sinew::tools

#endif  // SINEW_TOOLS_SINEW_TEACHER_COMMAND_H_
