#include "deploy/checkpoint/service/checkpoint_server.h"

#include <utility>

#include "common/status_macros.h"
#include "deploy/checkpoint/local_store.h"

namespace sinew::checkpoint {

absl::StatusOr<std::unique_ptr<CheckpointServer>> CheckpointServer::Start(
    const Options& options, const Clock& clock) {
  SINEW_ASSIGN_OR_RETURN(std::unique_ptr<ArtifactStore> store,
                         LocalStore::Open(options.folder, clock));
  std::unique_ptr<CheckpointServer> server(
      new CheckpointServer(std::move(store), options, clock));
  if (!options.metrics_address.empty()) {
    SINEW_ASSIGN_OR_RETURN(server->metrics_server_,
                           metrics::MetricsServer::Start(
                               options.metrics_address, server->registry_));
  }
  SINEW_ASSIGN_OR_RETURN(
      server->server_,
      rpc::Server::Start(
          {.address = options.address, .security = options.security},
          {&server->service_, &server->blobs_}));
  return server;
}

CheckpointServer::CheckpointServer(std::unique_ptr<ArtifactStore> store,
                                   const Options& options, const Clock& clock)
    : registry_({.role = "checkpoint", .build = options.build}),
      metrics_(registry_),
      store_(std::move(store)),
      service_(*store_, options.service, clock, metrics_),
      blobs_(service_.counted_blobs(), options.service.idle_timeout) {}

std::string CheckpointServer::metrics_address() const {
  return metrics_server_ == nullptr ? "" : metrics_server_->address();
}

}  // namespace sinew::checkpoint
