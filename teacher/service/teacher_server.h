#ifndef SINEW_TEACHER_SERVICE_TEACHER_SERVER_H_
#define SINEW_TEACHER_SERVICE_TEACHER_SERVER_H_

#include <memory>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/time/time.h"
#include "common/clock.h"
#include "common/metrics/metrics_server.h"
#include "common/metrics/registry.h"
#include "common/rpc/credentials.h"
#include "common/rpc/server.h"
#include "common/stop.h"
#include "teacher/local_annotator.h"
#include "teacher/service/batcher.h"
#include "teacher/service/teacher_metrics.h"
#include "teacher/service/teacher_service.h"
#include "teacher/teacher_policy.h"

namespace sinew::teacher {

// The role `sinew teacher`: a frozen policy behind a gRPC server of its own,
// with its metrics. It holds nothing that a restart would lose.
//
// Thread-safety: any thread. Ownership: owns everything but the clock.
// Blocking: Shutdown and the destructor, until calls have ended, at most their
// timeout (a second) plus 100 ms and the batch that is being computed. Errors:
// Create.
class TeacherServer {
 public:
  struct Options {
    // "unix:PATH" or "HOST:PORT"; port 0 takes a free one.
    std::string address = {};
    rpc::Security security = {};
    // That compute, >= 1.
    int threads = 1;
    Batcher::Options batches = {};
    // HOST:PORT of the metrics endpoint; empty: none.
    std::string metrics_address = {};
  };

  // INVALID_ARGUMENT: a bound out of range (named); as LocalAnnotator::Create,
  // rpc::Server::Start and MetricsServer::Start.
  static absl::StatusOr<std::unique_ptr<TeacherServer>> Create(
      const Options& options, const TeacherPolicy& policy, Clock& clock);
  ~TeacherServer();

  // Where it listens, with the ports that were taken; metrics may be empty.
  const std::string& address() const { return server_->address(); }
  std::string metrics_address() const;
  const v1::DescribeTeacherResponse& description() const {
    return annotator_->description();
  }

  // Health becomes NOT_SERVING; what waits is computed and answered, new calls
  // get UNAVAILABLE; after `timeout` running ones are cancelled.
  void Shutdown(absl::Duration timeout);

 private:
  TeacherServer(std::unique_ptr<LocalAnnotator> annotator,
                const Options& options, Clock& clock);

  metrics::Registry registry_;
  TeacherMetrics metrics_;
  const std::unique_ptr<LocalAnnotator> annotator_;
  Batcher batcher_;
  TeacherService service_;
  std::unique_ptr<metrics::MetricsServer> metrics_server_;
  // Last: its threads use all of the above.
  std::unique_ptr<rpc::Server> server_;
};

// Serves until `stop`; then gives running calls five seconds. Logs where it
// listens and what it serves.
absl::Status RunTeacher(const TeacherServer::Options& options,
                        const TeacherPolicy& policy, const StopToken& stop);

}  // namespace sinew::teacher

#endif  // SINEW_TEACHER_SERVICE_TEACHER_SERVER_H_
