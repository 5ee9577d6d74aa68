#include "tools/training/run_metrics.h"

namespace sinew::tools {

void RunMetrics::Update(const learner::IterationReport& report,
                        const RunFigures& figures) {
  recorder_.RecordIteration(report);
  recorder_.RecordSaveSeconds(figures.save_seconds);
}

}  // namespace sinew::tools
