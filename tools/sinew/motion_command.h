#ifndef SINEW_TOOLS_SINEW_MOTION_COMMAND_H_
#define SINEW_TOOLS_SINEW_MOTION_COMMAND_H_

#include "tools/sinew/command.h"

namespace sinew::tools {

// `sinew motion ...`: libraries of reference clips; what can be done with them
// is in motion_import.h, motion_inspect.h, motion_map.h, motion_render.h and
// motion_report.h.
void AddMotionCommand(CLI::App& app, Action& action);

}  // namespace sinew::tools

#endif  // SINEW_TOOLS_SINEW_MOTION_COMMAND_H_
