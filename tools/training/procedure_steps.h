#ifndef SINEW_TOOLS_TRAINING_PROCEDURE_STEPS_H_
#define SINEW_TOOLS_TRAINING_PROCEDURE_STEPS_H_

#include <functional>
#include <memory>
#include <string>

#include "absl/status/statusor.h"
#include "absl/time/time.h"
#include "common/clock.h"
#include "common/stop.h"
#include "tools/evaluation/evaluate_bundle.h"
#include "tools/evaluation/evaluation.h"
#include "tools/training/run_with_actors.h"
#include "tools/training/training_run.h"

namespace sinew::tools {

// What a procedure is made of.
struct ProcedureSteps {
  // Starts or resumes a run until it is finished, its minutes or iterations are
  // over, or stop; then its bundle/ is there.
  std::function<absl::StatusOr<TrainingRun::Result>(
      const TrainingRun::Options& options)>
      train;
  // Evaluates a bundle on a library and writes `out`.
  std::function<absl::StatusOr<evaluation::EvaluationFigures>(
      const std::string& bundle, const std::string& motions,
      const std::string& out, const evaluation::EvaluationOptions& options)>
      evaluate;
};

// RunWithActors and EvaluateBundle. Borrows the clock.
ProcedureSteps StepsWithActors(const LocalActors& actors, Clock& clock,
                               const StopToken& stop);

// The same for actors elsewhere: a stage's servers stay at options.listen until
// the next one is opened there, so that actors wait while the stage is
// evaluated; then their streams end and they come back. Where no stage is left
// to train, or one cannot be opened, nobody listens and actors give up by
// themselves. One caller.
class ServedStages {
 public:
  // Borrows the clock.
  ServedStages(Clock& clock, const StopToken& stop);
  ~ServedStages();
  ServedStages(const ServedStages&) = delete;
  ServedStages& operator=(const ServedStages&) = delete;

  // Borrows this.
  ProcedureSteps Steps();
  // Actors of the last stage go, or are cut off after `timeout`; if the
  // procedure is to go on (`done` is false), they wait for that instead.
  void Leave(bool done, absl::Duration timeout);

 private:
  absl::StatusOr<TrainingRun::Result> Train(
      const TrainingRun::Options& options);

  Clock& clock_;
  const StopToken stop_;
  std::unique_ptr<TrainingRun> last_;
  // Of the first stage; empty before. With port 0 it is that which was found.
  std::string address_;
};

}  // namespace sinew::tools

#endif  // SINEW_TOOLS_TRAINING_PROCEDURE_STEPS_H_
