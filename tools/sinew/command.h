#ifndef SINEW_TOOLS_SINEW_COMMAND_H_
#define SINEW_TOOLS_SINEW_COMMAND_H_

#include <CLI/CLI.hpp>
#include <functional>
#include <memory>
#include <string>
#include <utility>

#include "absl/status/status.h"
#include "common/stop.h"

namespace sinew::tools {

// What the command line asked for. Runs until done or `stop` is requested.
// INVALID_ARGUMENT and NOT_FOUND mean bad usage or configuration (exit code
// 2), other errors failure (1).
using Action = std::function<absl::Status(const StopToken& stop)>;

// Every subcommand NAME has one file NAME_command.{h,cc} with one function
//
//   void AddNameCommand(CLI::App& app, Action& action);
//
// that adds the subcommand and its options to `app`; if the user typed it,
// parsing sets `action`. Both outlive the parsing.
//
// `options` below are kept alive by the callbacks that use them.
template <typename Options>
CLI::App* AddSubcommand(
    CLI::App& app, const std::string& name, const std::string& description,
    std::shared_ptr<Options> options, Action& action,
    std::function<absl::Status(const Options&, const StopToken&)> run) {
  CLI::App* command = app.add_subcommand(name, description);
  command->callback([options, &action, run = std::move(run)] {
    action = [options, run](const StopToken& stop) {
      return run(*options, stop);
    };
  });
  return command;
}

}  // namespace sinew::tools

#endif  // SINEW_TOOLS_SINEW_COMMAND_H_
