#ifndef SINEW_TOOLS_SINEW_EVAL_COMMAND_H_
#define SINEW_TOOLS_SINEW_EVAL_COMMAND_H_

#include "tools/sinew/command.h"

namespace sinew::tools {

// `sinew eval`: the papers' metrics of a bundle on a motion library; or, with
// --table NAME=FILE ..., what several of them found as one table in Markdown.
void AddEvalCommand(CLI::App& app, Action& action);

}  // namespace sinew::tools

#endif  // SINEW_TOOLS_SINEW_EVAL_COMMAND_H_
