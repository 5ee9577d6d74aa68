#ifndef SINEW_TOOLS_SINEW_MOTION_REPORT_H_
#define SINEW_TOOLS_SINEW_MOTION_REPORT_H_

#include "tools/sinew/command.h"

namespace sinew::tools {

// `sinew motion report`: writes a library's report.html again, with more
// pictures or of some clips alone.
void AddMotionReport(CLI::App& motion, Action& action);

}  // namespace sinew::tools

#endif  // SINEW_TOOLS_SINEW_MOTION_REPORT_H_
