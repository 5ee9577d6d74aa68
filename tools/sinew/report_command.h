#ifndef SINEW_TOOLS_SINEW_REPORT_COMMAND_H_
#define SINEW_TOOLS_SINEW_REPORT_COMMAND_H_

#include "tools/sinew/command.h"

namespace sinew::tools {

// `sinew report`: report.html of a run directory.
void AddReportCommand(CLI::App& app, Action& action);

}  // namespace sinew::tools

#endif  // SINEW_TOOLS_SINEW_REPORT_COMMAND_H_
