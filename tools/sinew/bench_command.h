#ifndef SINEW_TOOLS_SINEW_BENCH_COMMAND_H_
#define SINEW_TOOLS_SINEW_BENCH_COMMAND_H_

#include <CLI/CLI.hpp>

#include "tools/sinew/command.h"

namespace sinew::tools {

// `sinew bench`: the benchmarks, every figure a ratio measured in that run.
void AddBenchCommand(CLI::App& app, Action& action);

}  // namespace sinew::tools

#endif  // SINEW_TOOLS_SINEW_BENCH_COMMAND_H_
