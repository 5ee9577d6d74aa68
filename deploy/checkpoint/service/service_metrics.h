#ifndef SINEW_DEPLOY_CHECKPOINT_SERVICE_SERVICE_METRICS_H_
#define SINEW_DEPLOY_CHECKPOINT_SERVICE_SERVICE_METRICS_H_

#include <map>
#include <string>

#include "absl/status/status.h"
#include "common/metrics/registry.h"

namespace sinew::checkpoint {

// The series of the checkpoint role. Thread-safe after construction; valid as
// long as the registry.
class ServiceMetrics {
 public:
  explicit ServiceMetrics(metrics::Registry& registry);

  // Counts one call of an rpc ("PutBlob" ...; another is our bug).
  void Count(const std::string& rpc, const absl::Status& status);

  metrics::Counter& received_bytes;
  metrics::Counter& sent_bytes;
  // Bytes of uploads in flight, and what they may be at most.
  metrics::Gauge& upload_bytes;
  metrics::Gauge& upload_limit_bytes;
  // When an artifact was last registered, seconds since 1970; 0: never.
  metrics::Gauge& last_artifact_timestamp_seconds;

 private:
  struct Calls {
    metrics::Counter* ok = nullptr;
    metrics::Counter* failed = nullptr;
  };

  std::map<std::string, Calls> calls_;
};

}  // namespace sinew::checkpoint

#endif  // SINEW_DEPLOY_CHECKPOINT_SERVICE_SERVICE_METRICS_H_
