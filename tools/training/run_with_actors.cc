#include "tools/training/run_with_actors.h"

#include <algorithm>
#include <memory>
#include <string>

#include "absl/strings/str_cat.h"
#include "absl/time/time.h"
#include "common/files.h"
#include "common/rpc/address.h"
#include "common/status_macros.h"
#include "common/temporary_folder.h"
#include "tools/training/actor_processes.h"

namespace sinew::tools {
namespace {

// For actors to finish what they hold once the run is over.
constexpr absl::Duration kDrainTimeout = absl::Seconds(10);

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

// `metrics`: of the learner; empty: none.
absl::StatusOr<ActorProcesses::Options> ActorOptions(
    const LocalActors& actors, const TrainingRun& run,
    const std::string& folder, int threads, const std::string& metrics) {
  ActorProcesses::Options options;
  options.argv = {
      actors.program,    "actor",
      "--learner",       run.address(),
      "--threads",       absl::StrCat(threads),
      "--cache",         JoinPath(folder, "cache"),
      "--name",          "actor-{index}",
      "--drain-seconds", absl::StrCat(absl::ToDoubleSeconds(kDrainTimeout))};
  if (!metrics.empty()) {
    SINEW_ASSIGN_OR_RETURN(rpc::Address address, rpc::ParseAddress(metrics));
    address.port = 0;
    options.argv.push_back("--metrics");
    options.argv.push_back(rpc::AddressString(address));
  }
  options.count = actors.count;
  options.log_folder = run.folder().actor_logs();
  options.grace = kDrainTimeout + absl::Seconds(2);
  return options;
}

}  // namespace

absl::StatusOr<TrainingRun::Result> RunWithActors(TrainingRun::Options options,
                                                  const LocalActors& actors,
                                                  Clock& clock,
                                                  const StopToken& stop) {
  const Budget budget = Divide(options.cores, actors.count,
                               options.recipe.rollouts().max_policy_lag() == 0);
  SINEW_ASSIGN_OR_RETURN(const auto folder, TemporaryFolder::Create());
  options.ranks = budget.ranks;
  options.listen = absl::StrCat("unix:", JoinPath(folder->path(), "s"));
  SINEW_ASSIGN_OR_RETURN(const std::unique_ptr<TrainingRun> run,
                         TrainingRun::Open(options, clock, stop));
  SINEW_ASSIGN_OR_RETURN(
      const ActorProcesses::Options actor_options,
      ActorOptions(actors, *run, folder->path(), budget.threads_per_actor,
                   options.metrics_address));
  SINEW_ASSIGN_OR_RETURN(const std::unique_ptr<ActorProcesses> processes,
                         ActorProcesses::Start(actor_options));
  run->SetChildren({[&processes] { return processes->check(); },
                    [&processes] { return processes->CpuSeconds(); }});
  const absl::Status status = run->Train();
  processes->BeginStop();
  run->Drain(kDrainTimeout);
  SINEW_RETURN_IF_ERROR(status);
  return run->result();
}

}  // namespace sinew::tools
