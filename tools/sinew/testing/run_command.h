#ifndef SINEW_TOOLS_SINEW_TESTING_RUN_COMMAND_H_
#define SINEW_TOOLS_SINEW_TESTING_RUN_COMMAND_H_

#include <CLI/CLI.hpp>
#include <string>

#include "absl/status/status.h"
#include "common/stop.h"
#include "gtest/gtest.h"
#include "tools/sinew/command.h"

namespace sinew::tools::testing {

// Runs what a user typed, from the subcommand's name on, as main.cc does:
//
//   RunCommand(AddReplayCommand, "replay --listen unix:/x", stop);
//
// `output`, if not null, is what it prints. Blocks as the subcommand does.
// Throws CLI::ParseError for options that are missing or wrong.
inline absl::Status RunCommand(void (*add)(CLI::App& app, Action& action),
                               const std::string& words,
                               const StopToken& stop = {},
                               std::string* output = nullptr) {
  CLI::App app;
  app.require_subcommand(1);
  Action action;
  add(app, action);
  app.parse(words);
  if (output == nullptr) return action(stop);
  ::testing::internal::CaptureStdout();
  const absl::Status status = action(stop);
  *output = ::testing::internal::GetCapturedStdout();
  return status;
}

// As RunCommand, of a server that ends as soon as it serves.
inline absl::Status RunServerBriefly(void (*add)(CLI::App& app, Action& action),
                                     const std::string& words) {
  StopSource stop;
  stop.request_stop();
  return RunCommand(add, words, stop.get_token());
}

}  // namespace sinew::tools::testing

#endif  // SINEW_TOOLS_SINEW_TESTING_RUN_COMMAND_H_
