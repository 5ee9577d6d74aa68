#include "actor/service/run_actor.h"

#include <mujoco/mujoco.h>
#include <unistd.h>

#include <array>
#include <memory>

#include "absl/strings/str_cat.h"
#include "actor/service/actor.h"
#include "actor/service/actor_metrics.h"
#include "actor/service/rollout_engine.h"
#include "common/build_info.h"
#include "common/cpu.h"
#include "common/logging.h"
#include "common/metrics/metrics_server.h"
#include "common/metrics/registry.h"
#include "common/status_macros.h"

namespace sinew::actor {
namespace {

std::string HostAndProcess() {
  std::array<char, 256> host = {};
  gethostname(host.data(), host.size() - 1);
  return absl::StrCat(host.data(), "/", getpid());
}

Actor::Options ActorOptions(const RunActorOptions& options) {
  Actor::Options actor;
  actor.dispatcher_address = options.dispatcher_address;
  actor.security = options.security;
  actor.cache_folder =
      options.cache_folder.empty() ? "cache" : options.cache_folder;
  actor.threads = options.threads > 0 ? options.threads : AvailableCpus();
  actor.name = options.name.empty() ? HostAndProcess() : options.name;
  actor.build = BuildIdentity();
  actor.mujoco_version = mj_versionString();
  actor.cpu_class = CpuClass();
  actor.drain_timeout = options.drain_timeout;
  actor.reconnect_timeout = options.reconnect_timeout;
  return actor;
}

}  // namespace

absl::Status RunActor(const RunActorOptions& options, const StopToken& stop) {
  metrics::Registry registry({.role = "actor", .build = BuildIdentity()});
  ActorMetrics metrics(registry);
  std::unique_ptr<metrics::MetricsServer> server;
  if (!options.metrics_address.empty()) {
    SINEW_ASSIGN_OR_RETURN(server, metrics::MetricsServer::Start(
                                       options.metrics_address, registry));
    LogInfo("serving metrics", {{"address", server->address()}});
  }
  RolloutEngine engine;
  SINEW_ASSIGN_OR_RETURN(const std::unique_ptr<Actor> actor,
                         Actor::Create(ActorOptions(options), engine, metrics));
  return actor->Run(stop);
}

}  // namespace sinew::actor
