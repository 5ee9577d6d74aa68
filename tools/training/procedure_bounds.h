#ifndef SINEW_TOOLS_TRAINING_PROCEDURE_BOUNDS_H_
#define SINEW_TOOLS_TRAINING_PROCEDURE_BOUNDS_H_

#include <cstdint>
#include <string>
#include <vector>

#include "learner/procedure/procedure.h"
#include "tools/training/training_run.h"

namespace sinew::tools {

// What bounds all stages of a procedure together: options.minutes and
// iterations, or else the recipe's.
//
// Thread-safety: a value. Ownership: none. Blocking: never. Errors: none.
class ProcedureBounds {
 public:
  explicit ProcedureBounds(const TrainingRun::Options& options);

  // Counts a stage that has ended, or what there is of one.
  void Spend(double train_seconds, int64_t iterations);
  // The bound that is reached, its value and what to do; empty: none.
  std::string Reached() const;
  // Limits a stage to what is left.
  void Limit(TrainingRun::Options& stage) const;

 private:
  double minutes_;      // 0: no bound
  int64_t iterations_;  // 0: no bound
  double spent_seconds_ = 0;
  int64_t spent_iterations_ = 0;
};

// Those of a procedure of which these stages have ended.
ProcedureBounds BoundsAfter(const TrainingRun::Options& options,
                            const std::vector<learner::FinishedStage>& ended);

}  // namespace sinew::tools

#endif  // SINEW_TOOLS_TRAINING_PROCEDURE_BOUNDS_H_
