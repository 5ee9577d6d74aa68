#ifndef SINEW_LEARNER_STATE_SAVE_METRICS_H_
#define SINEW_LEARNER_STATE_SAVE_METRICS_H_

#include "common/metrics/registry.h"

namespace sinew::learner {

// The series of saving training states. A bundle of references: thread-safe
// like them, valid as long as the registry.
struct SaveMetrics {
  explicit SaveMetrics(metrics::Registry& registry);

  metrics::Histogram& seconds;
  // Of the latest state that was saved.
  metrics::Gauge& bytes;
  metrics::Counter& saves;
  metrics::Counter& failures;
  // Seconds since 1970; 0 until the first.
  metrics::Gauge& last_success_timestamp_seconds;
};

}  // namespace sinew::learner

#endif  // SINEW_LEARNER_STATE_SAVE_METRICS_H_
