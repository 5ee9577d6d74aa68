// What the commands include besides. It puts objects into each source that sees
// it.
#ifndef SINEW_TOOLS_BUILD_PRECOMPILED_COMMAND_H_
#define SINEW_TOOLS_BUILD_PRECOMPILED_COMMAND_H_

#include <CLI/CLI.hpp>

#endif  // SINEW_TOOLS_BUILD_PRECOMPILED_COMMAND_H_
