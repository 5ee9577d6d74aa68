#ifndef SINEW_TOOLS_SINEW_CARD_COMMAND_H_
#define SINEW_TOOLS_SINEW_CARD_COMMAND_H_

#include "tools/sinew/command.h"

namespace sinew::tools {

// `sinew card --bundle B --motions LIB --out CARD.md [--eval FILE]
// [--fallen FILE] [--run RUN]`: the model card of a bundle for zoo/
// (tools/zoo).
void AddCardCommand(CLI::App& app, Action& action);

}  // namespace sinew::tools

#endif  // SINEW_TOOLS_SINEW_CARD_COMMAND_H_
