#include "tools/training/run_metrics.h"

#include <algorithm>

namespace sinew::tools {

void RunMetrics::UpdateActors(const learner::Dispatcher::Statistics& actors) {
  metrics_.actors_connected.Set(static_cast<double>(actors.actors));
  metrics_.orders_outstanding.Set(static_cast<double>(actors.orders_leased));
  metrics_.orders_reissued.Increment(
      static_cast<double>(actors.orders_reissued - before_.orders_reissued));
  metrics_.orders_returned.Increment(
      static_cast<double>(actors.orders_returned - before_.orders_returned));
  before_ = actors;
}

void RunMetrics::UpdateLearning(const learner::IterationReport& report) {
  const learner::UpdateStatistics& update = report.update;
  metrics_.iterations.Increment();
  metrics_.samples.Increment(static_cast<double>(update.samples));
  metrics_.policy_version.Set(static_cast<double>(report.policy_version));
  metrics_.policy_lag.Observe(static_cast<double>(report.policy_lag));
  metrics_.kl_divergence.Set(update.kl);
  metrics_.clipped_ratio.Set(update.clip_fraction);
  metrics_.policy_gradient_norm.Set(update.policy_gradient_norm);
  metrics_.value_gradient_norm.Set(update.value_gradient_norm);
  metrics_.non_finite_minibatches.Increment(
      static_cast<double>(update.non_finite));
  metrics_.mean_reward.Set(update.reward_mean);
  metrics_.episode_ends_terminated.Increment(
      static_cast<double>(report.failed_episodes));
  metrics_.episode_ends_time_limit.Increment(
      static_cast<double>(report.time_limit_episodes));
  metrics_.episode_ends_clip_end.Increment(
      static_cast<double>(report.clip_end_episodes));
  metrics_.episode_ends_diverged.Increment(
      static_cast<double>(report.diverged));
}

void RunMetrics::Update(const learner::IterationReport& report,
                        const RunFigures& figures,
                        const learner::Dispatcher::Statistics& actors) {
  metrics::StageSeconds& stages = metrics_.stage_seconds;
  stages.Add("wait", report.wait_seconds);
  stages.Add("learn", report.learn_seconds);
  stages.Add("publish", report.publish_seconds);
  stages.Add("evaluate", report.evaluation_core_seconds);
  stages.Add("checkpoint", figures.save_seconds);
  UpdateLearning(report);
  UpdateActors(actors);
  if (report.evaluation) {
    const SetSummary& overall = report.evaluation->overall;
    metrics_.evaluation_success_ratio.Set(
        static_cast<double>(overall.succeeded_starts) /
        std::max(1, overall.starts));
  }
}

}  // namespace sinew::tools
