#ifndef SINEW_TOOLS_SINEW_CURRICULUM_COMMAND_H_
#define SINEW_TOOLS_SINEW_CURRICULUM_COMMAND_H_

#include "tools/sinew/command.h"

namespace sinew::tools {

// `sinew curriculum RUN`: where the episodes of a run start, and what it finds
// hardest, from its newest training state; also while it trains.
void AddCurriculumCommand(CLI::App& app, Action& action);

}  // namespace sinew::tools

#endif  // SINEW_TOOLS_SINEW_CURRICULUM_COMMAND_H_
