#ifndef SINEW_TOOLS_EVALUATION_EVALUATION_H_
#define SINEW_TOOLS_EVALUATION_EVALUATION_H_

#include <optional>
#include <vector>

#include "absl/status/statusor.h"
#include "common/evaluation/evaluation_summary.h"
#include "common/stop.h"
#include "tools/evaluation/error_profile.h"
#include "tools/evaluation/fallen_figures.h"
#include "tools/evaluation/subject.h"

namespace sinew::evaluation {

struct EvaluationOptions {
  int starts = 32;      // evenly spaced phases per clip, >= 1
  double seconds = 10;  // that a looping clip runs on, > 0
  int threads = 1;      // >= 1; never changes results
  // The first so many clips get an error profile, >= 0.
  int profiles = 24;
  // Of EvaluateBundle: so many fallen starts as well (fallen_figures.h).
  std::optional<int> fallen = std::nullopt;
  // Of EvaluateBundle: a start fails beyond this mean distance of the bodies,
  // m; unset: the bundle's own.
  std::optional<double> max_mean_body_distance = std::nullopt;
};

struct Evaluation {
  EvaluationSummary policy;
  EvaluationSummary zero_action;
  // By clip; see EvaluationOptions::profiles.
  std::vector<ErrorProfile> profiles;
  // Not by Evaluate: of EvaluateFallen, where it was asked for.
  std::optional<FallenEvaluation> fallen = std::nullopt;
};

// The papers' metrics of a policy, and of the zero action on the same task.
// Same inputs, same bits, however many threads. Pure; profiles borrow from the
// subject. Blocking and errors: those of RunStarts and MakeEvaluationStarts.
absl::StatusOr<Evaluation> Evaluate(const Subject& subject,
                                    const EvaluationOptions& options,
                                    const StopToken& stop);

// Evaluate's `policy` alone, in half the time.
absl::StatusOr<EvaluationSummary> EvaluatePolicy(
    const Subject& subject, const EvaluationOptions& options,
    const StopToken& stop);

}  // namespace sinew::evaluation

#endif  // SINEW_TOOLS_EVALUATION_EVALUATION_H_
