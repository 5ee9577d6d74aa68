#ifndef SINEW_TOOLS_TRAINING_RUN_SERVICES_H_
#define SINEW_TOOLS_TRAINING_RUN_SERVICES_H_

#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "absl/status/statusor.h"
#include "absl/time/time.h"
#include "common/blobs/blob_source.h"
#include "common/metrics/learner_metrics.h"
#include "common/metrics/metrics_server.h"
#include "common/metrics/registry.h"
#include "common/rpc/credentials.h"
#include "learner/service/learner_metrics_recorder.h"
#include "learner/service/learner_server.h"
#include "learner/state/save_metrics.h"
#include "replay/client/replay.h"
#include "replay/replay_metrics.h"
#include "replay/table.h"

namespace sinew::replay {
class ReplayService;
}  // namespace sinew::replay

namespace sinew::tools {

// The servers of a run: the learner's, with replay in this process or a
// connection to one elsewhere, and the metrics endpoint. Series of actors and
// orders are as they stand when they are scraped, in an iteration or between;
// series of replay are there where it is.
//
// Thread-safety: any thread. Ownership: owns all; borrows the assets. Blocking:
// Drain up to its timeout; the destructor briefly. Errors: Start: an address
// in use (ALREADY_EXISTS), unusable addresses or TLS files.
class RunServices {
 public:
  struct Options {
    // Where actors come to.
    std::string listen;
    rpc::Security security = {};
    // Replay elsewhere; empty: in this process, with a bound of replay_bytes.
    std::string replay_address = {};
    int64_t replay_bytes = int64_t{256} << 20;
    // Where actors fetch assets; empty: here, from `assets`.
    std::string checkpoint_address = {};
    BlobSource* assets = nullptr;
    // Endpoint HOST:PORT; empty: none.
    std::string metrics_address = {};
    std::string run_id;
    std::string assets_sha256;
    absl::Duration reissue_after = absl::Seconds(20);
  };
  static absl::StatusOr<std::unique_ptr<RunServices>> Start(
      const Options& options);
  ~RunServices();

  // HOST:PORT of the metrics endpoint; empty: there is none.
  std::string metrics_address() const {
    return metrics_server_ == nullptr ? "" : metrics_server_->address();
  }
  learner::LearnerServer& server() { return *server_; }
  replay::Replay& replay() { return *replay_; }
  // The trainer's series, moved by whoever runs the iterations; those of actors
  // move by themselves.
  learner::LearnerMetricsRecorder& recorder() { return recorder_; }
  learner::SaveMetrics& save_metrics() { return save_metrics_; }

  // Actors finish what they hold and go, or are cut off after `timeout`.
  void Drain(absl::Duration timeout);
  // Their streams end, and they come back to whoever listens here next.
  void Interrupt();

 private:
  RunServices();
  absl::Status UseReplay(const Options& options);
  absl::Status StartServer(const Options& options);

  metrics::Registry registry_;
  metrics::LearnerMetrics metrics_;
  learner::SaveMetrics save_metrics_;
  learner::LearnerMetricsRecorder recorder_;
  std::optional<replay::ReplayMetrics> replay_metrics_;
  // In this process only.
  std::unique_ptr<replay::Table> table_;
  std::unique_ptr<replay::ReplayService> replay_service_;
  std::unique_ptr<replay::Replay> replay_;
  std::unique_ptr<learner::LearnerServer> server_;
  std::unique_ptr<metrics::MetricsServer> metrics_server_;
};

}  // namespace sinew::tools

#endif  // SINEW_TOOLS_TRAINING_RUN_SERVICES_H_
