#ifndef SINEW_COMMON_METRICS_PROCESS_METRICS_H_
#define SINEW_COMMON_METRICS_PROCESS_METRICS_H_

#include <vector>

#include "prometheus/collectable.h"
#include "prometheus/metric_family.h"

namespace sinew::metrics {

// The process_* series that Prometheus' client libraries have by custom (CPU,
// memory, descriptors, threads, start), read from /proc at each scrape. What
// cannot be read is left out. Thread-safe; blocks for microseconds.
class ProcessMetrics : public prometheus::Collectable {
 public:
  std::vector<prometheus::MetricFamily> Collect() const override;
};

}  // namespace sinew::metrics

#endif  // SINEW_COMMON_METRICS_PROCESS_METRICS_H_
