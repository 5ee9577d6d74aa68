#ifndef SINEW_TOOLS_BENCH_DISTILLATION_FIGURES_H_
#define SINEW_TOOLS_BENCH_DISTILLATION_FIGURES_H_

#include <optional>
#include <string>

#include "absl/status/statusor.h"
#include "proto/sinew/v1/recipe.pb.h"
#include "tools/bench/learner_figures.h"

namespace sinew::bench {

struct DistillationFigures {
  // Rows learnt from per CPU second of the fastest minibatch, on one thread.
  double rows_per_s = 0;
  double flops_per_s = 0;  // products of that minibatch, over its whole time
  std::optional<double> bfloat16_rows_per_s;  // where the CPU has it
  std::optional<double> bfloat16_ratio;       // over rows_per_s
  std::string bfloat16_reason;                // why there is none
};

// Minibatches of this recipe's student (distillation, with a latent or without)
// on made-up rows: gradients of all shards one after another, their sum and a
// step of the optimiser, in float32 and, where the CPU has it, in bfloat16 in
// turn, `minibatches` (>= 1) times each; the best of each counts. All shards
// learn from the same rows, which stay where they are: drawing and gathering
// them and their noise are not measured. CPU seconds; on "cuda" those of the
// wall.
//
// Blocking: fractions of a second per minibatch. Errors: INVALID_ARGUMENT for a
// recipe without distillation; those of MakeStudent and DistillationNetworks.
absl::StatusOr<DistillationFigures> MeasureDistillation(
    const v1::Recipe& recipe, const LearnerWidths& widths, int minibatches);

}  // namespace sinew::bench

#endif  // SINEW_TOOLS_BENCH_DISTILLATION_FIGURES_H_
