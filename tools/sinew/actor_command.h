#ifndef SINEW_TOOLS_SINEW_ACTOR_COMMAND_H_
#define SINEW_TOOLS_SINEW_ACTOR_COMMAND_H_

#include "tools/sinew/command.h"

namespace sinew::tools {

// `sinew actor`: one actor (actor/service/actor.h), until the learner drains or
// a stop is asked for.
void AddActorCommand(CLI::App& app, Action& action);

}  // namespace sinew::tools

#endif  // SINEW_TOOLS_SINEW_ACTOR_COMMAND_H_
