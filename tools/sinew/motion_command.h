#ifndef SINEW_TOOLS_SINEW_MOTION_COMMAND_H_
#define SINEW_TOOLS_SINEW_MOTION_COMMAND_H_

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "absl/status/status.h"

namespace sinew::tools {

struct ImportOptions {
  std::string character = "humanoid";
  std::string out;
  std::vector<std::string> files;
  double rate = 30;  // frames per second
  std::string provenance;
  std::string licence;
};

// Adds `import` and its options to `sinew motion`; `options` must outlive it.
CLI::App* AddMotionImport(CLI::App& motion, ImportOptions& options);

// `sinew motion import`: clips to a library, with a line per clip. One bad file
// does not stop the others; if none is good, an error and no library.
absl::Status RunMotionImport(const ImportOptions& options);

}  // namespace sinew::tools

#endif  // SINEW_TOOLS_SINEW_MOTION_COMMAND_H_
