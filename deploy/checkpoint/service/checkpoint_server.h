#ifndef SINEW_DEPLOY_CHECKPOINT_SERVICE_CHECKPOINT_SERVER_H_
#define SINEW_DEPLOY_CHECKPOINT_SERVICE_CHECKPOINT_SERVER_H_

#include <memory>
#include <string>

#include "absl/status/statusor.h"
#include "absl/time/time.h"
#include "common/blobs/blobs_service.h"
#include "common/clock.h"
#include "common/metrics/metrics_server.h"
#include "common/metrics/registry.h"
#include "common/rpc/credentials.h"
#include "common/rpc/server.h"
#include "deploy/checkpoint/client/artifact_store.h"
#include "deploy/checkpoint/service/checkpoint_service.h"
#include "deploy/checkpoint/service/service_metrics.h"

namespace sinew::checkpoint {

// The checkpoint role: a folder's store, served over gRPC, with metrics.
//
// Thread-safety: any thread. Ownership: owns store, sockets and threads;
// borrows the clock. Blocking: Shutdown and the destructor, as rpc::Server.
// Errors: Start.
class CheckpointServer {
 public:
  struct Options {
    // "HOST:PORT" or "unix:PATH"; port 0 takes a free one.
    std::string address;
    // Made if need be.
    std::string folder;
    // HOST:PORT for Prometheus; empty: none.
    std::string metrics_address = {};
    rpc::Security security = {};
    CheckpointService::Options service = {};
    // In sinew_build_info.
    std::string build = {};
  };

  // As LocalStore::Open, rpc::Server::Start and MetricsServer::Start.
  static absl::StatusOr<std::unique_ptr<CheckpointServer>> Start(
      const Options& options, const Clock& clock);

  // Where it listens, with the port that was taken.
  const std::string& address() const { return server_->address(); }
  // Empty: no endpoint.
  std::string metrics_address() const;

  // No new calls; running ones have `timeout`.
  void Shutdown(absl::Duration timeout) { server_->Shutdown(timeout); }

 private:
  CheckpointServer(std::unique_ptr<ArtifactStore> store, const Options& options,
                   const Clock& clock);

  metrics::Registry registry_;
  ServiceMetrics metrics_;
  const std::unique_ptr<ArtifactStore> store_;
  CheckpointService service_;
  BlobsService blobs_;
  std::unique_ptr<metrics::MetricsServer> metrics_server_;
  // Last: its threads use all of the above.
  std::unique_ptr<rpc::Server> server_;
};

}  // namespace sinew::checkpoint

#endif  // SINEW_DEPLOY_CHECKPOINT_SERVICE_CHECKPOINT_SERVER_H_
