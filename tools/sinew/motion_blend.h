#ifndef SINEW_TOOLS_SINEW_MOTION_BLEND_H_
#define SINEW_TOOLS_SINEW_MOTION_BLEND_H_

#include "tools/sinew/command.h"

namespace sinew::tools {

// `sinew motion blend FIRST SECOND`: two clips of any format, each trimmed if
// wished, joined over a gap into one clip of a library, with report.json,
// report.html and a table as `sinew motion import` has. The library holds it
// alone, or with the clips of --with. --list: many such pairs in one library.
void AddMotionBlend(CLI::App& motion, Action& action);

}  // namespace sinew::tools

#endif  // SINEW_TOOLS_SINEW_MOTION_BLEND_H_
