#ifndef SINEW_TOOLS_BENCH_LEARNER_FIGURES_H_
#define SINEW_TOOLS_BENCH_LEARNER_FIGURES_H_

#include "absl/status/statusor.h"
#include "proto/sinew/v1/recipe.pb.h"

namespace sinew::bench {

struct LearnerFigures {
  double samples_per_s = 0;     // of the fastest update
  double flops_per_s = 0;       // products of that update, over its whole time
  double gemm_flops_per_s = 0;  // best plain float32 product, one thread
  // flops_per_s over ranks * gemm_flops_per_s.
  double gemm_ratio = 0;
  // The same per second of CPU time: what the ranks' waiting and other load on
  // the machine do not touch.
  double cpu_gemm_ratio = 0;
};

// Updates a learner of this recipe `updates` times on made-up segments of the
// recipe's size (learner/ppo/synthetic_segments.h), the plain product measured
// between them, and takes the best of each: other load on the machine slows
// both alike. The KL stop is off, so that every update does all epochs.
//
// Blocking: seconds. Errors: those of PpoLearner.
absl::StatusOr<LearnerFigures> MeasureLearner(const v1::Recipe& recipe,
                                              int observation_width,
                                              int action_width, int ranks,
                                              int updates);

}  // namespace sinew::bench

#endif  // SINEW_TOOLS_BENCH_LEARNER_FIGURES_H_
