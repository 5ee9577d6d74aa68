#ifndef SINEW_LEARNER_SERVICE_LEARNER_METRICS_RECORDER_H_
#define SINEW_LEARNER_SERVICE_LEARNER_METRICS_RECORDER_H_

#include <cstdint>
#include <functional>

#include "absl/status/status.h"
#include "absl/time/time.h"
#include "common/metrics/learner_metrics.h"
#include "learner/dispatcher/dispatcher.h"
#include "learner/trainer/trainer.h"

namespace sinew::learner {

// Turns what trainer, dispatcher and saving report into the learner's series.
//
//   Dispatcher::Options::on_apply = ObserveApply(metrics)
//   per iteration: RecordIteration(report) RecordActors(statistics)
//   per save:      RecordSave(save)
//
// Thread-safety: one caller (ObserveApply's function: any thread). Ownership:
// borrows the series. Blocking: never. Errors: none.
class LearnerMetricsRecorder {
 public:
  explicit LearnerMetricsRecorder(metrics::LearnerMetrics& metrics)
      : metrics_(metrics) {}

  void RecordIteration(const IterationReport& report);

  // Totals only grow; counters move by what was added since the last call.
  void RecordActors(const Dispatcher::Statistics& statistics);

  // One attempt to save the training state.
  struct Save {
    absl::Status status;
    double seconds = 0;
    int64_t bytes = 0;  // written; 0: unknown
    absl::Time when;    // wall time of its end
  };
  void RecordSave(const Save& save);

 private:
  metrics::LearnerMetrics& metrics_;
  Dispatcher::Statistics before_;
};

// For Dispatcher::Options::on_apply. Borrows the series.
std::function<void(double seconds)> ObserveApply(
    metrics::LearnerMetrics& metrics);

}  // namespace sinew::learner

#endif  // SINEW_LEARNER_SERVICE_LEARNER_METRICS_RECORDER_H_
