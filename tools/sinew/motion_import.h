#ifndef SINEW_TOOLS_SINEW_MOTION_IMPORT_H_
#define SINEW_TOOLS_SINEW_MOTION_IMPORT_H_

#include "tools/sinew/command.h"

namespace sinew::tools {

// `sinew motion import`: clips of any format to a library of a character, with
// report.json, report.html, a progress bar and a table. Exit code 0 if at least
// one clip was imported; one bad file does not stop the others.
void AddMotionImport(CLI::App& motion, Action& action);

}  // namespace sinew::tools

#endif  // SINEW_TOOLS_SINEW_MOTION_IMPORT_H_
