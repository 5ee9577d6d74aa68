#ifndef SINEW_TOOLS_EVALUATION_EVALUATE_BUNDLE_H_
#define SINEW_TOOLS_EVALUATION_EVALUATE_BUNDLE_H_

#include <optional>
#include <string>

#include "absl/status/statusor.h"
#include "common/evaluation/evaluation_summary.h"
#include "common/stop.h"
#include "tools/evaluation/evaluation.h"
#include "tools/evaluation/fallen_figures.h"

namespace sinew::evaluation {

// Policy and zero action.
struct EvaluationFigures {
  EvaluationSummary policy;
  EvaluationSummary zero_action;
  std::optional<FallenEvaluation> fallen;  // EvaluationOptions::fallen
  // That the library's import turned away; unset: unknown.
  std::optional<int> rejected_clips;
};

// What `sinew eval` does: evaluates the policy of a bundle folder on a library
// folder and writes `out` (EvaluationJson), atomically. Blocking: computes, see
// Evaluate. Errors: those of LoadBundleSubject, CheckFallenStarts,
// EvaluateFallen, Evaluate and writing; then nothing was written.
absl::StatusOr<EvaluationFigures> EvaluateBundle(
    const std::string& bundle, const std::string& motions,
    const std::string& out, const EvaluationOptions& options,
    const StopToken& stop);

}  // namespace sinew::evaluation

#endif  // SINEW_TOOLS_EVALUATION_EVALUATE_BUNDLE_H_
