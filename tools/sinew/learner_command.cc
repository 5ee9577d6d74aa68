#include "tools/sinew/learner_command.h"

#include <memory>
#include <string>

#include "common/clock.h"
#include "common/status_macros.h"
#include "tools/sinew/run_flags.h"
#include "tools/training/procedure_run.h"
#include "tools/training/procedure_steps.h"
#include "tools/training/training_run.h"

namespace sinew::tools {
namespace {

// For actors to finish what they hold once the run is over.
constexpr absl::Duration kDrainTimeout = absl::Seconds(20);

struct LearnerOptions {
  RunFlags run;
  std::string listen;
  std::string replay;
  std::string checkpoint;
  std::string metrics;
};

absl::Status RunLearner(const LearnerOptions& options, const StopToken& stop) {
  SystemClock clock;
  SINEW_ASSIGN_OR_RETURN(TrainingRun::Options run_options,
                         MakeRunOptions(options.run));
  run_options.listen = options.listen;
  run_options.replay_address = options.replay;
  run_options.checkpoint_address = options.checkpoint;
  run_options.metrics_address = options.metrics;
  if (run_options.recipe.has_procedure()) {
    ServedStages stages(clock, stop);
    const absl::Status status = RunProcedure(run_options, stages.Steps(), stop);
    stages.Leave(status.ok() && !stop.stop_requested(), kDrainTimeout);
    return status;
  }
  SINEW_ASSIGN_OR_RETURN(const std::unique_ptr<TrainingRun> run,
                         TrainingRun::Open(run_options, clock, stop));
  const absl::Status status = run->Train();
  run->Leave(kDrainTimeout);
  return status;
}

}  // namespace

void AddLearnerCommand(CLI::App& app, Action& action) {
  auto options = std::make_shared<LearnerOptions>();
  auto* command = AddSubcommand<LearnerOptions>(
      app, "learner", "start or resume a run for actors elsewhere", options,
      action, RunLearner);
  AddRunFlags(*command, options->run);
  command
      ->add_option("--listen", options->listen,
                   "where actors come to, HOST:PORT or unix:PATH")
      ->required();
  command->add_option("--replay", options->replay,
                      "a replay service, as the actors reach it, too; default: "
                      "in this process");
  command->add_option("--checkpoint", options->checkpoint,
                      "a checkpoint service, as the actors reach it, too; "
                      "default: in the run directory");
  command->add_option("--metrics", options->metrics,
                      "HOST:PORT for Prometheus; default: none");
}

}  // namespace sinew::tools
