#include "tools/sinew/curriculum_command.h"

#include <cstdio>
#include <memory>
#include <string>

#include "absl/strings/str_format.h"
#include "common/clock.h"
#include "common/status_macros.h"
#include "tools/curriculum/run_curriculum.h"
#include "tools/sinew/security_flags.h"
#include "tools/training/shown_folder.h"

namespace sinew::tools {
namespace {

struct CurriculumOptions {
  std::string run;
  int hardest = 10;
  bool json = false;
  StateStore states;
};

absl::Status RunCurriculumCommand(const CurriculumOptions& options,
                                  const StopToken& stop) {
  const SystemClock clock;
  StateStore states = options.states;
  states.stop = stop;
  SINEW_ASSIGN_OR_RETURN(const RunCurriculum curriculum,
                         ReadRunCurriculum(options.states.where.empty()
                                               ? FolderWithState(options.run)
                                               : options.run,
                                           clock, states));
  for (const std::string& warning : curriculum.warnings) {
    absl::FPrintF(stderr, "sinew: %s\n", warning);
  }
  if (options.json) {
    // The path is bytes, as it was typed.
    absl::PrintF("%s\n", CurriculumJson(curriculum, options.hardest)
                             .dump(2, ' ', /*ensure_ascii=*/false,
                                   nlohmann::json::error_handler_t::replace));
  } else {
    absl::PrintF("%s", CurriculumText(curriculum, options.hardest));
  }
  return absl::OkStatus();
}

}  // namespace

void AddCurriculumCommand(CLI::App& app, Action& action) {
  auto options = std::make_shared<CurriculumOptions>();
  auto* command = AddSubcommand<CurriculumOptions>(
      app, "curriculum", "where the episodes of a run start", options, action,
      RunCurriculumCommand);
  command
      ->add_option(
          "run", options->run,
          "run directory; of a procedure: its newest stage with a state")
      ->required();
  command
      ->add_option("--hardest", options->hardest,
                   "clips and bins that are listed")
      ->check(CLI::Range(1, 1000000))
      ->capture_default_str();
  command->add_flag("--json", options->json, "as JSON");
  command->add_option(
      "--checkpoint", options->states.where,
      "where the learner keeps its states: a checkpoint service "
      "or a folder; default: in the run directory");
  AddSecurityFlags(*command, options->states.security);
}

}  // namespace sinew::tools
