#ifndef SINEW_TOOLS_SINEW_SAMPLE_COMMAND_H_
#define SINEW_TOOLS_SINEW_SAMPLE_COMMAND_H_

#include "tools/sinew/command.h"

namespace sinew::tools {

// `sinew sample`: the prior of a bundle alone moves the body; figures,
// pictures, page.
void AddSampleCommand(CLI::App& app, Action& action);

}  // namespace sinew::tools

#endif  // SINEW_TOOLS_SINEW_SAMPLE_COMMAND_H_
