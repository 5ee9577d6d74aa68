#ifndef SINEW_TOOLS_SINEW_RUN_FLAGS_H_
#define SINEW_TOOLS_SINEW_RUN_FLAGS_H_

#include <CLI/CLI.hpp>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "common/rpc/credentials.h"
#include "tools/training/training_run.h"

namespace sinew::tools {

// What `sinew train` and `sinew learner` have in common.
struct RunFlags {
  std::string recipe;   // name or file
  std::string motions;  // library folder
  std::string run;      // run folder; resumed if it holds a state
  std::string character = "humanoid";
  double minutes = 0;      // of train_s in all; 0: the recipe's
  int64_t iterations = 0;  // in all; 0: the recipe's
  std::optional<uint64_t> seed;
  int threads = 0;  // 0: AvailableCpus
  std::string init;
  std::vector<std::string> primitives;
  std::string continue_from;
  std::vector<std::string> teachers;
  std::vector<std::string> teacher_evaluations;
  double teacher_patience = 120;  // seconds
  double teacher_timeout = 30;    // seconds
  bool migrate_library = false;
  std::vector<std::string> set;
  rpc::Security security;  // towards roles elsewhere
};

// Adds the flags to a command; `flags` outlives the parsing.
void AddRunFlags(CLI::App& command, RunFlags& flags);

// Loads the recipe and fills in what the flags say; addresses are the caller's.
// INVALID_ARGUMENT, NOT_FOUND.
absl::StatusOr<TrainingRun::Options> MakeRunOptions(const RunFlags& flags);

// Threads that the command may use.
int ThreadsOf(const RunFlags& flags);

}  // namespace sinew::tools

#endif  // SINEW_TOOLS_SINEW_RUN_FLAGS_H_
