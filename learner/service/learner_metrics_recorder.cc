#include "learner/service/learner_metrics_recorder.h"

#include <algorithm>
#include <cstdint>

namespace sinew::learner {

void LearnerMetricsRecorder::RecordDistillation(
    const DistillationFigures& figures) {
  metrics_.distillation_action_error_radians.Set(figures.action_error_rad);
  metrics_.distillation_latent_kl_nats.Set(figures.latent_kl);
  metrics_.distillation_continuity_loss.Set(figures.continuity_loss);
  metrics_.memory_rows.Set(static_cast<double>(figures.memory_rows));
  metrics_.labelled_rows.Increment(static_cast<double>(figures.labelled_rows));
}

void LearnerMetricsRecorder::RecordIteration(const IterationReport& report) {
  const UpdateStatistics& update = report.update;
  metrics::StageSeconds& stages = metrics_.stage_seconds;
  stages.Add("wait", report.wait_seconds);
  stages.Add("label", report.label_seconds);
  stages.Add("learn", report.learn_seconds);
  stages.Add("publish", report.publish_seconds);
  stages.Add("evaluate", report.evaluation_core_seconds);
  metrics_.iterations.Increment();
  metrics_.samples.Increment(static_cast<double>(update.samples));
  metrics_.physics_steps.Increment(static_cast<double>(report.physics_steps));
  metrics_.policy_version.Set(static_cast<double>(report.policy_version));
  for (int64_t i = 0; i < report.segments; ++i) {
    metrics_.policy_lag.Observe(static_cast<double>(report.policy_lag));
  }
  metrics_.episode_ends_terminated.Increment(
      static_cast<double>(report.failed_episodes));
  metrics_.episode_ends_time_limit.Increment(
      static_cast<double>(report.time_limit_episodes));
  metrics_.episode_ends_clip_end.Increment(
      static_cast<double>(report.clip_end_episodes));
  metrics_.episode_ends_diverged.Increment(
      static_cast<double>(report.diverged));
  metrics_.kl_divergence.Set(update.kl);
  metrics_.clipped_ratio.Set(update.clip_fraction);
  metrics_.policy_gradient_norm.Set(update.policy_gradient_norm);
  metrics_.value_gradient_norm.Set(update.value_gradient_norm);
  metrics_.non_finite_minibatches.Increment(
      static_cast<double>(update.non_finite));
  metrics_.mean_reward.Set(update.reward_mean);
  if (update.distillation) RecordDistillation(*update.distillation);
  if (!report.evaluation.has_value()) return;
  const SetSummary& overall = report.evaluation->overall;
  metrics_.evaluation_success_ratio.Set(
      static_cast<double>(overall.succeeded_starts) /
      std::max(1, overall.starts));
}

void LearnerMetricsRecorder::RecordActors(
    const Dispatcher::Statistics& statistics) {
  const auto add = [](metrics::Counter& counter, int64_t before, int64_t now) {
    counter.Increment(static_cast<double>(now - before));
  };
  metrics_.actors_connected.Set(static_cast<double>(statistics.actors));
  metrics_.orders_outstanding.Set(
      static_cast<double>(statistics.orders_leased));
  metrics_.orders_waiting.Set(static_cast<double>(statistics.orders_waiting));
  metrics_.applied_policy_version.Set(
      static_cast<double>(statistics.applied_version));
  add(metrics_.actors_refused, before_.refused_actors,
      statistics.refused_actors);
  add(metrics_.actors_lost, before_.lost_actors, statistics.lost_actors);
  add(metrics_.orders_reissued, before_.orders_reissued,
      statistics.orders_reissued);
  add(metrics_.orders_returned, before_.orders_returned,
      statistics.orders_returned);
  before_ = statistics;
}

std::function<void(double seconds)> ObserveApply(
    metrics::LearnerMetrics& metrics) {
  return [&metrics](double seconds) {
    metrics.publish_to_apply_seconds.Observe(seconds);
  };
}

}  // namespace sinew::learner
