#ifndef SINEW_TOOLS_SINEW_LEARNER_COMMAND_H_
#define SINEW_TOOLS_SINEW_LEARNER_COMMAND_H_

#include "tools/sinew/command.h"

namespace sinew::tools {

// `sinew learner`: the same run as `sinew train`, for actors (and, if asked, a
// replay and a checkpoint service) that run elsewhere.
void AddLearnerCommand(CLI::App& app, Action& action);

}  // namespace sinew::tools

#endif  // SINEW_TOOLS_SINEW_LEARNER_COMMAND_H_
