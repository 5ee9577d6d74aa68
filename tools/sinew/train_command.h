#ifndef SINEW_TOOLS_SINEW_TRAIN_COMMAND_H_
#define SINEW_TOOLS_SINEW_TRAIN_COMMAND_H_

#include "tools/sinew/command.h"

namespace sinew::tools {

// `sinew train`: starts or resumes a run and goes on until it is done or a stop
// is asked for; saves then.
void AddTrainCommand(CLI::App& app, Action& action);

}  // namespace sinew::tools

#endif  // SINEW_TOOLS_SINEW_TRAIN_COMMAND_H_
