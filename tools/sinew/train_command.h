#ifndef SINEW_TOOLS_SINEW_TRAIN_COMMAND_H_
#define SINEW_TOOLS_SINEW_TRAIN_COMMAND_H_

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/status.h"

namespace sinew::tools {

struct TrainOptions {
  std::string recipe;     // name or file
  std::string motions;    // library folder
  std::string run;        // run folder; resumed if it holds a state
  std::string character = "humanoid";
  double minutes = 0;     // of train_s in all; 0: the recipe's
  int64_t iterations = 0; // in all; 0: the recipe's
  std::optional<uint64_t> seed;
  int threads = 0;        // for rollouts and learning; 0: all cores
  std::vector<std::string> set;
};

// `sinew train`: starts or resumes a run and goes on until it is done or a stop
// is asked for; saves then. Blocking: for as long as training takes.
absl::Status RunTrain(const TrainOptions& options);

}  // namespace sinew::tools

#endif  // SINEW_TOOLS_SINEW_TRAIN_COMMAND_H_
