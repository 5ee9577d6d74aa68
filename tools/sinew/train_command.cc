#include "tools/sinew/train_command.h"

#include <memory>
#include <string>

#include "common/clock.h"
#include "common/status_macros.h"
#include "tools/sinew/run_flags.h"
#include "tools/training/procedure_run.h"
#include "tools/training/procedure_steps.h"
#include "tools/training/run_with_actors.h"
#include "tools/training/training_run.h"

namespace sinew::tools {
namespace {

struct TrainOptions {
  RunFlags run;
  int actors = 1;
  std::string metrics;
};

absl::Status RunTrain(const TrainOptions& options, const StopToken& stop) {
  SystemClock clock;
  SINEW_ASSIGN_OR_RETURN(TrainingRun::Options run_options,
                         MakeRunOptions(options.run));
  run_options.metrics_address = options.metrics;
  const LocalActors actors = {.count = options.actors};
  if (run_options.recipe.has_procedure()) {
    return RunProcedure(run_options, StepsWithActors(actors, clock, stop),
                        stop);
  }
  return RunWithActors(run_options, actors, clock, stop).status();
}

}  // namespace

void AddTrainCommand(CLI::App& app, Action& action) {
  auto options = std::make_shared<TrainOptions>();
  auto* command = AddSubcommand<TrainOptions>(
      app, "train", "start or resume a run", options, action, RunTrain);
  AddRunFlags(*command, options->run);
  command->add_option("--actors", options->actors, "child actor processes")
      ->check(CLI::Range(1, 256))
      ->capture_default_str();
  command->add_option("--metrics", options->metrics,
                      "HOST:PORT for Prometheus, actors on free ports of HOST "
                      "(RUN/logs names them); default: none");
}

}  // namespace sinew::tools
