#ifndef SINEW_TOOLS_SINEW_MOTION_MAP_H_
#define SINEW_TOOLS_SINEW_MOTION_MAP_H_

#include "tools/sinew/command.h"

namespace sinew::tools {

// `sinew motion map`: prints the skeleton map of a file (which joint is what)
// as a text proto, to be edited and given back with `import --map`.
void AddMotionMap(CLI::App& motion, Action& action);

}  // namespace sinew::tools

#endif  // SINEW_TOOLS_SINEW_MOTION_MAP_H_
