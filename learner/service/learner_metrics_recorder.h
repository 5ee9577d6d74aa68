#ifndef SINEW_LEARNER_SERVICE_LEARNER_METRICS_RECORDER_H_
#define SINEW_LEARNER_SERVICE_LEARNER_METRICS_RECORDER_H_

#include <functional>

#include "common/metrics/learner_metrics.h"
#include "learner/dispatcher/dispatcher.h"
#include "learner/learner.h"
#include "learner/trainer/trainer.h"

namespace sinew::learner {

// Turns what trainer, dispatcher and saving report into the learner's series.
//
//   Dispatcher::Options::on_apply = ObserveApply(metrics)
//   per iteration: RecordIteration(report)
//   per save:      RecordSaveSeconds(seconds)
//   per scrape:    RecordActors(statistics)
//
// Thread-safety: one caller, and one, who may be another, of RecordActors
// (ObserveApply's function: any thread). Ownership:
// borrows the series. Blocking: never. Errors: none.
class LearnerMetricsRecorder {
 public:
  explicit LearnerMetricsRecorder(metrics::LearnerMetrics& metrics)
      : metrics_(metrics) {}

  void RecordIteration(const IterationReport& report);

  // Totals only grow; counters move by what was added since the last call.
  void RecordActors(const Dispatcher::Statistics& statistics);

  // Of the loop's time; the series of saving itself are SaveMetrics.
  void RecordSaveSeconds(double seconds) {
    metrics_.stage_seconds.Add("checkpoint", seconds);
  }

 private:
  void RecordDistillation(const DistillationFigures& figures);

  metrics::LearnerMetrics& metrics_;
  Dispatcher::Statistics before_;
};

// For Dispatcher::Options::on_apply. Borrows the series.
std::function<void(double seconds)> ObserveApply(
    metrics::LearnerMetrics& metrics);

}  // namespace sinew::learner

#endif  // SINEW_LEARNER_SERVICE_LEARNER_METRICS_RECORDER_H_
