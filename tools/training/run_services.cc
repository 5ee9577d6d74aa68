#include "tools/training/run_services.h"

#include <mujoco/mujoco.h>

#include "absl/strings/str_cat.h"
#include "common/build_info.h"
#include "common/cpu.h"
#include "common/logging.h"
#include "common/rpc/channel.h"
#include "common/status_macros.h"
#include "replay/client/replay_client.h"
#include "replay/local_replay.h"
#include "replay/service/replay_service.h"

namespace sinew::tools {
namespace {

constexpr double kHeartbeatSeconds = 2;

learner::Dispatcher::Options DispatcherOptions(
    const RunServices::Options& options, metrics::LearnerMetrics& metrics) {
  learner::Dispatcher::Options result;
  result.welcome.set_run_id(options.run_id);
  result.welcome.set_heartbeat_seconds(kHeartbeatSeconds);
  result.welcome.set_replay_address(options.replay_address);
  result.welcome.set_checkpoint_address(options.checkpoint_address);
  result.welcome.set_assets_sha256(options.assets_sha256);
  result.build = BuildIdentity();
  result.mujoco_version = mj_versionString();
  result.cpu_class = CpuClass();
  result.reissue_after = options.reissue_after;
  result.on_apply = learner::ObserveApply(metrics);
  return result;
}

}  // namespace

RunServices::RunServices()
    : registry_({.role = "learner", .build = BuildIdentity()}),
      metrics_(registry_),
      save_metrics_(registry_),
      recorder_(metrics_) {}

RunServices::~RunServices() {
  metrics_server_ = nullptr;  // scrapes ask the server
  // Handlers that wait for room end before the server does.
  if (table_ != nullptr) table_->Close();
  server_ = nullptr;
}

absl::Status RunServices::UseReplay(const Options& options) {
  if (options.replay_address.empty()) {
    replay_metrics_.emplace(registry_);
    table_ = std::make_unique<replay::Table>(
        replay::Table::Options{.limit_bytes = options.replay_bytes},
        *replay_metrics_);
    replay_service_ = std::make_unique<replay::ReplayService>(*table_);
    replay_ = std::make_unique<replay::LocalReplay>(*table_);
    return absl::OkStatus();
  }
  SINEW_ASSIGN_OR_RETURN(
      const auto channel,
      rpc::MakeChannel(options.replay_address, options.security));
  replay::ReplayClient::Options client;
  client.peer = absl::StrCat("replay ", options.replay_address);
  replay_ = std::make_unique<replay::ReplayClient>(channel, client);
  return absl::OkStatus();
}

absl::Status RunServices::StartServer(const Options& options) {
  learner::LearnerServer::Options server;
  server.listen = options.listen;
  server.security = options.security;
  server.dispatcher = DispatcherOptions(options, metrics_);
  server.assets = options.assets;
  if (replay_service_ != nullptr) {
    server.services.push_back(replay_service_.get());
  }
  SINEW_ASSIGN_OR_RETURN(server_, learner::LearnerServer::Start(server));
  LogInfo("the learner listens", {{"address", server_->address()}});
  registry_.BeforeScrape(
      [this] { recorder_.RecordActors(server_->dispatcher().statistics()); });
  if (options.metrics_address.empty()) return absl::OkStatus();
  SINEW_ASSIGN_OR_RETURN(
      metrics_server_,
      metrics::MetricsServer::Start(options.metrics_address, registry_));
  LogInfo("serving metrics", {{"address", metrics_server_->address()}});
  return absl::OkStatus();
}

absl::StatusOr<std::unique_ptr<RunServices>> RunServices::Start(
    const Options& options) {
  std::unique_ptr<RunServices> result(new RunServices());
  SINEW_RETURN_IF_ERROR(result->UseReplay(options));
  SINEW_RETURN_IF_ERROR(result->StartServer(options));
  return result;
}

void RunServices::Interrupt() { server_->Interrupt(); }

void RunServices::Drain(absl::Duration timeout) { server_->Drain(timeout); }

}  // namespace sinew::tools
