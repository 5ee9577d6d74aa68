#ifndef SINEW_TOOLS_SINEW_MOTION_INSPECT_H_
#define SINEW_TOOLS_SINEW_MOTION_INSPECT_H_

#include "tools/sinew/command.h"

namespace sinew::tools {

// `sinew motion inspect`: what is in a library, and how good it is.
void AddMotionInspect(CLI::App& motion, Action& action);

}  // namespace sinew::tools

#endif  // SINEW_TOOLS_SINEW_MOTION_INSPECT_H_
