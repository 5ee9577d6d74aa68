#ifndef SINEW_TOOLS_TRAINING_RUN_METRICS_H_
#define SINEW_TOOLS_TRAINING_RUN_METRICS_H_

#include "common/metrics/learner_metrics.h"
#include "learner/service/learner_metrics_recorder.h"
#include "learner/trainer/trainer.h"
#include "tools/training/metrics_log.h"

namespace sinew::tools {

// Moves the learner's series after each iteration; those of its actors move by
// themselves (run_services.h).
//
// Thread-safety: one caller. Ownership: borrows the series. Blocking: never.
// Errors: none.
class RunMetrics {
 public:
  explicit RunMetrics(metrics::LearnerMetrics& metrics) : recorder_(metrics) {}

  void Update(const learner::IterationReport& report,
              const RunFigures& figures);

 private:
  learner::LearnerMetricsRecorder recorder_;
};

}  // namespace sinew::tools

#endif  // SINEW_TOOLS_TRAINING_RUN_METRICS_H_
