#include "tools/bench/learner_figures.h"

#include <algorithm>
#include <chrono>
#include <ctime>
#include <limits>
#include <memory>
#include <thread>
#include <vector>

#include "common/config/recipe.h"
#include "common/status_macros.h"
#include "learner/ppo/ppo_learner.h"
#include "learner/ppo/synthetic_segments.h"
#include "learner/torch/runtime.h"

namespace sinew::bench {
namespace {

double MeasureGemm() {
  double flops = 0;
  std::jthread([&] {
    learner::UseOneThread();
    flops = learner::PlainMatmulFlops();
  }).join();
  return flops;
}

}  // namespace

absl::StatusOr<LearnerFigures> MeasureLearner(const v1::Recipe& recipe,
                                              int observation_width,
                                              int action_width, int ranks,
                                              int updates) {
  v1::Recipe full = WithDefaults(recipe);
  full.mutable_ppo()->set_kl_stop(std::numeric_limits<float>::max());
  SINEW_ASSIGN_OR_RETURN(
      const std::unique_ptr<learner::PpoLearner> learner,
      learner::PpoLearner::Create(full, {.observation_width = observation_width,
                                         .action_width = action_width,
                                         .ranks = ranks}));
  const v1::Rollouts& rollouts = full.rollouts();
  const std::vector<v1::Segment> segments = learner::MakeSyntheticSegments(
      {.observation_width = observation_width,
       .action_width = action_width,
       .orders = rollouts.environments() / rollouts.environments_per_order(),
       .environments = rollouts.environments_per_order(),
       .steps = rollouts.horizon(),
       .terminated_share = 0.005,
       .truncated_share = 0.003},
      learner->graph(), learner->weights(), /*iteration=*/0);
  const std::vector<const v1::Segment*> pointers = learner::Pointers(segments);
  LearnerFigures figures;
  double flops_per_cpu_s = 0;
  for (int i = 0; i < updates; ++i) {
    const std::clock_t cpu_begin = std::clock();
    const auto begin = std::chrono::steady_clock::now();
    SINEW_ASSIGN_OR_RETURN(const learner::UpdateStatistics statistics,
                           learner->Update(pointers, i));
    const std::chrono::duration<double> seconds =
        std::chrono::steady_clock::now() - begin;
    const double cpu_seconds =
        static_cast<double>(std::clock() - cpu_begin) / CLOCKS_PER_SEC;
    flops_per_cpu_s = std::max(flops_per_cpu_s, statistics.flops / cpu_seconds);
    figures.samples_per_s =
        std::max(figures.samples_per_s, statistics.samples / seconds.count());
    figures.flops_per_s =
        std::max(figures.flops_per_s, statistics.flops / seconds.count());
    if (i % 4 == 0) {
      figures.gemm_flops_per_s =
          std::max(figures.gemm_flops_per_s, MeasureGemm());
    }
  }
  figures.gemm_ratio = figures.flops_per_s / (ranks * figures.gemm_flops_per_s);
  figures.cpu_gemm_ratio = flops_per_cpu_s / figures.gemm_flops_per_s;
  return figures;
}

}  // namespace sinew::bench
