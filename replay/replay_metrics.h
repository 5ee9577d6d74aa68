#ifndef SINEW_REPLAY_REPLAY_METRICS_H_
#define SINEW_REPLAY_REPLAY_METRICS_H_

#include <map>

#include "common/metrics/registry.h"
#include "proto/sinew/v1/replay.pb.h"

namespace sinew::replay {

// The series of a replay table. Thread-safe; valid as long as the registry.
struct ReplayMetrics {
  explicit ReplayMetrics(metrics::Registry& registry);

  metrics::Counter& accepted;
  metrics::Counter& taken;
  metrics::Gauge& bytes;
  metrics::Gauge& limit_bytes;
  metrics::Gauge& writers_waiting;
  // Seconds that writers waited for room, all together.
  metrics::Counter& blocked_seconds;
  // One per verdict that refuses.
  std::map<v1::PutSegmentResponse::Verdict, metrics::Counter*> refused;
};

}  // namespace sinew::replay

#endif  // SINEW_REPLAY_REPLAY_METRICS_H_
