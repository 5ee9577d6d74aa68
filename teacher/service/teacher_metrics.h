#ifndef SINEW_TEACHER_SERVICE_TEACHER_METRICS_H_
#define SINEW_TEACHER_SERVICE_TEACHER_METRICS_H_

#include <map>

#include "absl/status/status.h"
#include "common/metrics/registry.h"

namespace sinew::teacher {

// The series of the teacher role. Thread-safe after construction; valid as
// long as the registry.
class TeacherMetrics {
 public:
  explicit TeacherMetrics(metrics::Registry& registry);

  // Counts one Annotate that took so many seconds, by what came of it.
  void Count(const absl::Status& status, double seconds);

  // Rows that were labelled, and the sizes of batches.
  metrics::Counter& rows;
  metrics::Histogram& batch_rows;
  // Rows that wait, and what they may be at most.
  metrics::Gauge& queue_rows;
  metrics::Gauge& queue_limit_rows;
  // From a call's arrival to its answer.
  metrics::Histogram& request_seconds;
  // Seconds that batches were computed for.
  metrics::Counter& annotate_seconds;

 private:
  std::map<absl::StatusCode, metrics::Counter*> requests_;
  metrics::Counter* failed_;
};

}  // namespace sinew::teacher

#endif  // SINEW_TEACHER_SERVICE_TEACHER_METRICS_H_
