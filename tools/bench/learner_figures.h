#ifndef SINEW_TOOLS_BENCH_LEARNER_FIGURES_H_
#define SINEW_TOOLS_BENCH_LEARNER_FIGURES_H_

#include <optional>
#include <string>

#include "absl/status/statusor.h"
#include "proto/sinew/v1/recipe.pb.h"

namespace sinew::bench {

struct LearnerFigures {
  double samples_per_s = 0;    // of the fastest update
  double flops_per_s = 0;      // products of that update, over its whole time
  double cpu_flops_per_s = 0;  // the same over the ranks' processor time
};

struct LearnerRatios {
  double gemm_flops_per_s = 0;  // best plain float32 product, one thread
  LearnerFigures one_rank, two_ranks;
  std::optional<LearnerFigures> bfloat16;  // one rank; where the CPU has it
  std::string bfloat16_reason;             // why there is none
  // one_rank.flops_per_s over gemm_flops_per_s, and the same by processor time,
  // which other load on the machine hardly touches.
  double gemm_ratio = 0;
  double cpu_gemm_ratio = 0;
  // samples/s over those of one rank in float32.
  double two_ranks_ratio = 0;
  std::optional<double> bfloat16_ratio;
};

// Columns of a task (tools/training/task_setup.h says what each is).
struct LearnerWidths {
  int observation = 0;
  int self_observation = 0;  // with a latent
  int action = 0;
};

// Updates learners of this recipe (one rank, two ranks, and in bfloat16 where
// the CPU has it) in turn, `updates` times each, on made-up segments of the
// recipe's size (learner/ppo/synthetic_segments.h), the plain product measured
// between them, and takes the best of each: other load on the machine slows
// all alike. The KL stop is off, so that every update does all epochs.
//
// Blocking: seconds per update. Errors: those of PpoLearner.
absl::StatusOr<LearnerRatios> MeasureLearner(const v1::Recipe& recipe,
                                             const LearnerWidths& widths,
                                             int updates);

}  // namespace sinew::bench

#endif  // SINEW_TOOLS_BENCH_LEARNER_FIGURES_H_
