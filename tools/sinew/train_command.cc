#include "tools/sinew/train_command.h"

#include <algorithm>
#include <memory>
#include <string>

#include "absl/strings/str_cat.h"
#include "common/clock.h"
#include "common/files.h"
#include "common/status_macros.h"
#include "common/temporary_folder.h"
#include "tools/sinew/run_flags.h"
#include "tools/training/actor_processes.h"
#include "tools/training/training_run.h"

namespace sinew::tools {
namespace {

// For actors to finish what they hold once the run is over.
constexpr absl::Duration kDrainTimeout = absl::Seconds(10);

struct TrainOptions {
  RunFlags run;
  int actors = 1;
  std::string metrics;
};

// The thread budget. Under lag 0 actors and learner take turns and each has all
// cores; otherwise they share them.
struct Budget {
  int ranks = 1;
  int threads_per_actor = 1;
};

Budget Divide(int cores, int actors, bool take_turns) {
  Budget budget;
  budget.ranks = take_turns ? cores : std::max(1, cores / 2);
  const int for_actors = take_turns ? cores : std::max(1, cores - budget.ranks);
  budget.threads_per_actor = std::max(1, for_actors / actors);
  return budget;
}

ActorProcesses::Options ActorOptions(const TrainOptions& options,
                                     const TrainingRun& run,
                                     const std::string& folder, int threads) {
  ActorProcesses::Options actors;
  actors.argv = {
      "/proc/self/exe",  "actor",
      "--learner",       run.address(),
      "--threads",       absl::StrCat(threads),
      "--cache",         JoinPath(folder, "cache"),
      "--name",          "actor-{index}",
      "--drain-seconds", absl::StrCat(absl::ToDoubleSeconds(kDrainTimeout))};
  actors.count = options.actors;
  actors.log_folder = run.folder().actor_logs();
  actors.grace = kDrainTimeout + absl::Seconds(2);
  return actors;
}

absl::Status RunTrain(const TrainOptions& options, const StopToken& stop) {
  SystemClock clock;
  SINEW_ASSIGN_OR_RETURN(TrainingRun::Options run_options,
                         MakeRunOptions(options.run));
  const Budget budget =
      Divide(ThreadsOf(options.run), options.actors,
             run_options.recipe.rollouts().max_policy_lag() == 0);
  SINEW_ASSIGN_OR_RETURN(const auto folder, TemporaryFolder::Create());
  run_options.ranks = budget.ranks;
  run_options.listen = absl::StrCat("unix:", JoinPath(folder->path(), "s"));
  run_options.metrics_address = options.metrics;
  SINEW_ASSIGN_OR_RETURN(const std::unique_ptr<TrainingRun> run,
                         TrainingRun::Open(run_options, clock, stop));
  SINEW_ASSIGN_OR_RETURN(
      const std::unique_ptr<ActorProcesses> actors,
      ActorProcesses::Start(ActorOptions(options, *run, folder->path(),
                                         budget.threads_per_actor)));
  run->SetChildren({[&actors] { return actors->check(); },
                    [&actors] { return actors->CpuSeconds(); }});
  const absl::Status status = run->Train();
  actors->BeginStop();
  run->Drain(kDrainTimeout);
  return status;
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
                      "HOST:PORT for Prometheus; default: none");
}

}  // namespace sinew::tools
