#include "learner/state/save_metrics.h"

namespace sinew::learner {

SaveMetrics::SaveMetrics(metrics::Registry& registry)
    : seconds(registry.AddHistogram(
          "sinew_checkpoint_seconds",
          "Time to write a training state, beside training.",
          metrics::SecondsBuckets())),
      bytes(registry.AddGauge("sinew_checkpoint_bytes",
                              "Size of the latest training state saved.")),
      saves(registry.AddCounter("sinew_checkpoint_saves_total",
                                "Training states saved.")),
      failures(registry.AddCounter("sinew_checkpoint_failures_total",
                                   "Training states that could not be saved.")),
      last_success_timestamp_seconds(registry.AddGauge(
          "sinew_checkpoint_last_success_timestamp_seconds",
          "When a training state was last saved; 0: never.")) {}

}  // namespace sinew::learner
