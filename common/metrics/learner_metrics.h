#ifndef SINEW_COMMON_METRICS_LEARNER_METRICS_H_
#define SINEW_COMMON_METRICS_LEARNER_METRICS_H_

#include "common/metrics/registry.h"
#include "common/metrics/stage_seconds.h"

namespace sinew::metrics {

// The series of the learner and its dispatcher. A bundle of references:
// thread-safe like them, valid as long as the registry.
struct LearnerMetrics {
  explicit LearnerMetrics(Registry& registry);

  // "label" (waiting for a teacher), "learn", "publish", "evaluate", "wait"
  // (for segments), "checkpoint".
  StageSeconds stage_seconds;
  Counter& iterations;
  Counter& samples;
  Counter& physics_steps;
  Gauge& policy_version;
  // Newest version that an actor has acted with.
  Gauge& applied_policy_version;
  // Versions between a segment's snapshot and the one it is learned into.
  Histogram& policy_lag;
  // From an actor's first hearing of a version to its acting with it: fetching
  // and preparing it, and what the actor had to finish before.
  Histogram& publish_to_apply_seconds;
  Gauge& actors_connected;
  Counter& actors_refused;
  Counter& actors_lost;
  Gauge& orders_waiting;
  Gauge& orders_outstanding;
  Counter& orders_reissued;
  Counter& orders_returned;
  Counter& episode_ends_terminated;
  Counter& episode_ends_time_limit;
  Counter& episode_ends_clip_end;
  Counter& episode_ends_diverged;
  Gauge& kl_divergence;
  Gauge& clipped_ratio;
  Gauge& policy_gradient_norm;
  Gauge& value_gradient_norm;
  Counter& non_finite_minibatches;
  Gauge& mean_reward;
  // Of distillations; 0 in others.
  Gauge& distillation_action_error_radians;
  Gauge& distillation_latent_kl_nats;
  Gauge& distillation_continuity_loss;
  Gauge& memory_rows;
  Counter& labelled_rows;
  // Share of evaluation starts that survived, latest evaluation.
  Gauge& evaluation_success_ratio;
};

}  // namespace sinew::metrics

#endif  // SINEW_COMMON_METRICS_LEARNER_METRICS_H_
