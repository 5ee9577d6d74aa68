#ifndef SINEW_TOOLS_SINEW_MOTION_RENDER_H_
#define SINEW_TOOLS_SINEW_MOTION_RENDER_H_

#include "tools/sinew/command.h"

namespace sinew::tools {

// `sinew motion render`: film strips of a library's clips or, through ffmpeg
// where it is installed, videos.
void AddMotionRender(CLI::App& motion, Action& action);

}  // namespace sinew::tools

#endif  // SINEW_TOOLS_SINEW_MOTION_RENDER_H_
