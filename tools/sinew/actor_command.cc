#include "tools/sinew/actor_command.h"

#include <memory>

#include "absl/time/time.h"
#include "actor/service/run_actor.h"
#include "common/status_macros.h"
#include "tools/sinew/finite_range.h"
#include "tools/sinew/role_logger.h"
#include "tools/sinew/security_flags.h"

namespace sinew::tools {
namespace {

struct ActorOptions {
  actor::RunActorOptions run;
  double drain_seconds = 20;
  double reconnect_seconds = 120;
};

absl::Status RunActorCommand(const ActorOptions& options,
                             const StopToken& stop) {
  SINEW_RETURN_IF_ERROR(LogAs("actor"));
  actor::RunActorOptions run = options.run;
  run.drain_timeout = absl::Seconds(options.drain_seconds);
  run.reconnect_timeout = absl::Seconds(options.reconnect_seconds);
  return actor::RunActor(run, stop);
}

}  // namespace

void AddActorCommand(CLI::App& app, Action& action) {
  auto options = std::make_shared<ActorOptions>();
  CLI::App* command = AddSubcommand<ActorOptions>(
      app, "actor", "simulate for a learner", options, action, RunActorCommand);
  actor::RunActorOptions& run = options->run;
  command
      ->add_option("--learner", run.dispatcher_address,
                   "its address, HOST:PORT or unix:PATH")
      ->required();
  command->add_option("--cache", run.cache_folder,
                      "folder for what is fetched; default: cache");
  command->add_option("--threads", run.threads, "threads (default: all cores)")
      ->check(ThreadRange());
  command->add_option("--metrics", run.metrics_address,
                      "HOST:PORT for Prometheus; default: none");
  command->add_option("--name", run.name,
                      "in the learner's logs; default: host/process");
  command
      ->add_option("--drain-seconds", options->drain_seconds,
                   "to finish and send what runs when it is to end")
      ->check(FiniteRange(0, 86400))
      ->capture_default_str();
  command
      ->add_option("--reconnect-seconds", options->reconnect_seconds,
                   "how long the learner may be away")
      ->check(FiniteRange(0, 86400))
      ->capture_default_str();
  AddSecurityFlags(*command, run.security);
}

}  // namespace sinew::tools
