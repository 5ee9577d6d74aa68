#include "tools/sinew/motion_import.h"

#include <memory>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "common/status_macros.h"
#include "sim/import/importer.h"
#include "tools/sinew/finite_range.h"
#include "tools/sinew/run_import.h"

namespace sinew::tools {
namespace {

struct Options {
  ImportFlags flags;
  std::vector<std::string> files;
  std::vector<double> trim;  // from, to, seconds
  bool loop = false;
};

absl::Status Run(const Options& options, const StopToken& stop) {
  SINEW_ASSIGN_OR_RETURN(import::ImportOptions importing,
                         ImportOptionsOf(options.flags));
  if (!options.trim.empty()) {
    importing.edits.from_s = options.trim[0];
    importing.edits.to_s = options.trim[1];
  }
  importing.edits.loop = options.loop;
  return RunImport(options.flags, options.files, importing, stop);
}

}  // namespace

void AddMotionImport(CLI::App& motion, Action& action) {
  auto options = std::make_shared<Options>();
  auto* command = AddSubcommand<Options>(motion, "import", "clips to a library",
                                         options, action, Run);
  AddImportFlags(command, &options->flags);
  const char* group = "What to do with every clip";
  command->add_option("--trim", options->trim, "keep from, to (two numbers, s)")
      ->expected(2)
      ->allow_extra_args(false)
      ->check(FiniteRange(0, 1e6))
      ->group(group);
  command
      ->add_flag("--loop", options->loop,
                 "keep the frames that repeat best, as a loop")
      ->group(group);
  command->add_option("files", options->files, "clips, or folders of them")
      ->required();
}

}  // namespace sinew::tools
