#ifndef SINEW_REPLAY_SERVICE_REPLAY_SERVER_H_
#define SINEW_REPLAY_SERVICE_REPLAY_SERVER_H_

#include <cstdint>
#include <memory>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/time/time.h"
#include "common/metrics/metrics_server.h"
#include "common/metrics/registry.h"
#include "common/rpc/credentials.h"
#include "common/rpc/server.h"
#include "common/stop.h"
#include "replay/replay_metrics.h"
#include "replay/service/replay_service.h"
#include "replay/table.h"

namespace sinew::replay {

// The role `sinew replay`: a table behind a gRPC server of its own, with its
// metrics. It holds segments in memory only: after a restart the learner opens
// its orders again, and what was lost is run again.
//
// Thread-safety: any thread. Ownership: owns everything. Blocking: Shutdown
// and the destructor, until calls have ended, at most their timeout (a second)
// plus 100 ms. Errors: Create: ALREADY_EXISTS: an address is in use (named);
// INVALID_ARGUMENT, FAILED_PRECONDITION: addresses and credentials.
class ReplayServer {
 public:
  struct Options {
    // "unix:PATH" or "HOST:PORT"; port 0 takes a free one.
    std::string address;
    rpc::Security security = {};
    // Bound of the segments held or arriving, bytes, >= 1 MiB.
    int64_t limit_bytes = int64_t{256} << 20;
    // HOST:PORT of the metrics endpoint; empty: none.
    std::string metrics_address = {};
  };

  static absl::StatusOr<std::unique_ptr<ReplayServer>> Create(
      const Options& options);
  ~ReplayServer();

  // Where it listens, with the ports that were taken; metrics may be empty.
  const std::string& address() const { return server_->address(); }
  std::string metrics_address() const;

  // Calls that wait end with UNAVAILABLE; running ones get `timeout`.
  void Shutdown(absl::Duration timeout);

 private:
  explicit ReplayServer(const Options& options);

  metrics::Registry registry_;
  ReplayMetrics metrics_;
  Table table_;
  ReplayService service_;
  std::unique_ptr<metrics::MetricsServer> metrics_server_;
  std::unique_ptr<rpc::Server> server_;
};

// Serves until `stop`; then gives running calls five seconds. Logs where it
// listens.
absl::Status RunReplay(const ReplayServer::Options& options,
                       const StopToken& stop);

}  // namespace sinew::replay

#endif  // SINEW_REPLAY_SERVICE_REPLAY_SERVER_H_
