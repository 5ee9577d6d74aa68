#ifndef SINEW_LEARNER_SERVICE_LEARNER_SERVER_H_
#define SINEW_LEARNER_SERVICE_LEARNER_SERVER_H_

#include <memory>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/time/time.h"
#include "common/blobs/blob_ring.h"
#include "common/blobs/blob_source.h"
#include "common/blobs/blob_sources.h"
#include "common/blobs/blobs_service.h"
#include "common/rpc/credentials.h"
#include "common/rpc/server.h"
#include "grpcpp/impl/codegen/service_type.h"
#include "learner/dispatcher/dispatcher.h"

namespace sinew::learner {

// What actors see of a learner, on one address: the dispatcher, blobs
// (snapshots, and assets unless they are elsewhere), health, and services of
// other roles that share the process (replay, under `sinew train`).
//
//   Start -> train -> Drain (actors go) -> close what handlers wait for (the
//   replay table) -> destroy
//
// Thread-safety: any thread. Ownership: owns dispatcher, snapshots and server;
// borrows assets and other services. Blocking: Drain, at most its timeout and
// the reaction to cancellation; the destructor cancels what is left. Errors:
// Start, as rpc::Server (ALREADY_EXISTS: the address is in use).
class LearnerServer {
 public:
  struct Options {
    // "unix:PATH" or "HOST:PORT", port 0 for a free one.
    std::string listen;
    rpc::Security security = {};
    Dispatcher::Options dispatcher;
    // Served beside the snapshots; null: none.
    BlobSource* assets = nullptr;
    // Registered too.
    std::vector<grpc::Service*> services = {};
  };

  static absl::StatusOr<std::unique_ptr<LearnerServer>> Start(
      const Options& options);
  ~LearnerServer();

  // Where it listens, with the port that was taken.
  const std::string& address() const { return server_->address(); }
  Dispatcher& dispatcher() { return *dispatcher_; }
  BlobRing& snapshots() { return snapshots_; }

  // No more orders: actors finish what they hold and go, or are cut off after
  // `timeout`.
  void Drain(absl::Duration timeout);
  // Ends all streams, so that actors come back to the next learner here. So
  // does the destructor, where neither was called.
  void Interrupt();

 private:
  explicit LearnerServer(const Options& options);

  const std::unique_ptr<Dispatcher> dispatcher_;
  BlobRing snapshots_;
  BlobSources sources_;
  BlobsService blobs_;
  // Last: its handlers use all of the above.
  std::unique_ptr<rpc::Server> server_;
};

}  // namespace sinew::learner

#endif  // SINEW_LEARNER_SERVICE_LEARNER_SERVER_H_
