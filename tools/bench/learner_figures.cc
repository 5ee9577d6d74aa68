#include "tools/bench/learner_figures.h"

#include <algorithm>
#include <chrono>
#include <ctime>
#include <limits>
#include <memory>
#include <string>
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

std::vector<v1::Segment> MakeSegments(const v1::Recipe& recipe,
                                      const LearnerWidths& widths,
                                      const learner::PpoLearner& learner) {
  const v1::Rollouts& rollouts = recipe.rollouts();
  return learner::MakeSyntheticSegments(
      {.observation_width = widths.observation,
       .action_width = widths.action,
       .latent_width = RecordedLatentWidth(recipe),
       .orders = rollouts.environments() / rollouts.environments_per_order(),
       .environments = rollouts.environments_per_order(),
       .steps = rollouts.horizon(),
       .terminated_share = 0.005,
       .truncated_share = 0.003},
      learner.graph(), learner.weights(), /*iteration=*/0);
}

// One update; `best` keeps the fastest.
absl::Status Update(learner::PpoLearner& learner,
                    const std::vector<const v1::Segment*>& segments,
                    int64_t iteration, LearnerFigures& best) {
  const std::clock_t cpu_begin = std::clock();
  const auto begin = std::chrono::steady_clock::now();
  SINEW_ASSIGN_OR_RETURN(const learner::UpdateStatistics statistics,
                         learner.Update(segments, iteration));
  const std::chrono::duration<double> seconds =
      std::chrono::steady_clock::now() - begin;
  const double cpu =
      static_cast<double>(std::clock() - cpu_begin) / CLOCKS_PER_SEC;
  best.samples_per_s =
      std::max(best.samples_per_s,
               static_cast<double>(statistics.samples) / seconds.count());
  best.flops_per_s =
      std::max(best.flops_per_s, statistics.flops / seconds.count());
  best.cpu_flops_per_s = std::max(best.cpu_flops_per_s, statistics.flops / cpu);
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<LearnerRatios> MeasureLearner(const v1::Recipe& recipe,
                                             const LearnerWidths& widths,
                                             int updates) {
  v1::Recipe full = WithDefaults(recipe);
  full.mutable_ppo()->set_kl_stop(std::numeric_limits<float>::max());
  full.mutable_ppo()->set_bfloat16(false);
  const auto create =
      [&](int ranks) -> absl::StatusOr<std::unique_ptr<learner::PpoLearner>> {
    SINEW_ASSIGN_OR_RETURN(
        std::unique_ptr<learner::PpoLearner> learner,
        learner::PpoLearner::Create(
            full, {.observation_width = widths.observation,
                   .self_observation_width = widths.self_observation,
                   .action_width = widths.action,
                   .ranks = ranks}));
    // Untrained primitives cost as much as trained ones.
    if (full.network().has_composer()) {
      SINEW_RETURN_IF_ERROR(learner->InitFrom(learner->weights()));
    }
    return learner;
  };
  SINEW_ASSIGN_OR_RETURN(const auto one, create(1));
  SINEW_ASSIGN_OR_RETURN(const auto two, create(2));
  std::unique_ptr<learner::PpoLearner> bfloat16;
  LearnerRatios ratios;
  const absl::Status has_bfloat16 = learner::CheckBfloat16(
      learner::DetectCpu(), full.device(), "ppo.bfloat16");
  ratios.bfloat16_reason = std::string(has_bfloat16.message());
  if (has_bfloat16.ok()) {
    full.mutable_ppo()->set_bfloat16(true);
    SINEW_ASSIGN_OR_RETURN(bfloat16, create(1));
    ratios.bfloat16.emplace();
  }
  const std::vector<v1::Segment> segments = MakeSegments(full, widths, *one);
  const std::vector<const v1::Segment*> pointers = learner::Pointers(segments);
  for (int i = 0; i < updates; ++i) {
    SINEW_RETURN_IF_ERROR(Update(*one, pointers, i, ratios.one_rank));
    SINEW_RETURN_IF_ERROR(Update(*two, pointers, i, ratios.two_ranks));
    if (bfloat16 != nullptr) {
      SINEW_RETURN_IF_ERROR(Update(*bfloat16, pointers, i, *ratios.bfloat16));
    }
    if (i % 4 == 0) {
      ratios.gemm_flops_per_s =
          std::max(ratios.gemm_flops_per_s, MeasureGemm());
    }
  }
  const LearnerFigures& base = ratios.one_rank;
  ratios.gemm_ratio = base.flops_per_s / ratios.gemm_flops_per_s;
  ratios.cpu_gemm_ratio = base.cpu_flops_per_s / ratios.gemm_flops_per_s;
  ratios.two_ranks_ratio = ratios.two_ranks.samples_per_s / base.samples_per_s;
  if (ratios.bfloat16.has_value()) {
    ratios.bfloat16_ratio = ratios.bfloat16->samples_per_s / base.samples_per_s;
  }
  return ratios;
}

}  // namespace sinew::bench
