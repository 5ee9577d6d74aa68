#ifndef SINEW_TOOLS_SINEW_MOTION_COMMAND_H_
#define SINEW_TOOLS_SINEW_MOTION_COMMAND_H_

#include "tools/sinew/command.h"

namespace sinew::tools {

// `sinew motion import`: clips to a library, with a line per clip. One bad file
// does not stop the others; if none is good, an error and no library.
void AddMotionCommand(CLI::App& app, Action& action);

}  // namespace sinew::tools

#endif  // SINEW_TOOLS_SINEW_MOTION_COMMAND_H_
