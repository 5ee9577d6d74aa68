#ifndef SINEW_TOOLS_SINEW_RENDER_COMMAND_H_
#define SINEW_TOOLS_SINEW_RENDER_COMMAND_H_

#include "tools/sinew/command.h"

namespace sinew::tools {

// `sinew render`: film strip and video of a bundle beside its reference.
void AddRenderCommand(CLI::App& app, Action& action);

}  // namespace sinew::tools

#endif  // SINEW_TOOLS_SINEW_RENDER_COMMAND_H_
