#include "common/metrics/learner_metrics.h"

#include <string>

namespace sinew::metrics {
namespace {

Counter& EpisodeEnds(Registry& registry, const std::string& reason) {
  return registry.AddCounter("sinew_episode_ends_total",
                             "Episodes that ended, by reason.",
                             {{"reason", reason}});
}

Gauge& GradientNorm(Registry& registry, const std::string& network) {
  return registry.AddGauge("sinew_gradient_norm",
                           "Mean gradient norm of the latest update before "
                           "clipping.",
                           {{"network", network}});
}

}  // namespace

LearnerMetrics::LearnerMetrics(Registry& registry)
    : stage_seconds(registry, {"label", "learn", "publish", "evaluate", "wait",
                               "checkpoint"}),
      iterations(
          registry.AddCounter("sinew_iterations_total", "Iterations learned.")),
      samples(registry.AddCounter("sinew_samples_total",
                                  "Valid rows learned from.")),
      physics_steps(registry.AddCounter(
          "sinew_physics_steps_total",
          "Physics steps behind the segments learned from.")),
      policy_version(registry.AddGauge("sinew_policy_version",
                                       "Version of the latest snapshot.")),
      applied_policy_version(
          registry.AddGauge("sinew_applied_policy_version",
                            "Newest version that an actor has acted with.")),
      policy_lag(registry.AddHistogram(
          "sinew_policy_lag_versions",
          "Versions between a segment's snapshot and the update that uses it.",
          {0, 1, 2, 3, 4, 6, 8, 12, 16, 32})),
      publish_to_apply_seconds(registry.AddHistogram(
          "sinew_publish_to_apply_seconds",
          "From an actor's first hearing of a version to its acting with it.",
          SecondsBuckets())),
      actors_connected(registry.AddGauge("sinew_actors_connected",
                                         "Actors with a live stream.")),
      actors_refused(registry.AddCounter(
          "sinew_actors_refused_total",
          "Registrations refused: other build, CPU class or protocol.")),
      actors_lost(registry.AddCounter(
          "sinew_actors_lost_total",
          "Streams that ended while their actor held orders.")),
      orders_waiting(registry.AddGauge("sinew_orders_waiting",
                                       "Orders that no actor holds.")),
      orders_outstanding(registry.AddGauge("sinew_orders_outstanding",
                                           "Orders given out and not done.")),
      orders_reissued(registry.AddCounter(
          "sinew_orders_reissued_total",
          "Orders given to a further actor because they were late.")),
      orders_returned(registry.AddCounter("sinew_orders_returned_total",
                                          "Orders that actors gave back.")),
      episode_ends_terminated(EpisodeEnds(registry, "terminated")),
      episode_ends_time_limit(EpisodeEnds(registry, "time_limit")),
      episode_ends_clip_end(EpisodeEnds(registry, "clip_end")),
      episode_ends_diverged(EpisodeEnds(registry, "diverged")),
      kl_divergence(registry.AddGauge(
          "sinew_kl_divergence", "Mean KL divergence after the last pass.")),
      clipped_ratio(
          registry.AddGauge("sinew_clipped_ratio",
                            "Share of rows whose probability ratio was "
                            "clipped in the latest update.")),
      policy_gradient_norm(GradientNorm(registry, "policy")),
      value_gradient_norm(GradientNorm(registry, "value")),
      non_finite_minibatches(registry.AddCounter(
          "sinew_non_finite_total",
          "Minibatches skipped because their loss was not finite.")),
      mean_reward(registry.AddGauge("sinew_mean_reward",
                                    "Mean reward of the latest iteration.")),
      distillation_action_error_radians(registry.AddGauge(
          "sinew_distillation_action_error_radians",
          "Root mean square of target errors in the latest update.")),
      distillation_latent_kl_nats(registry.AddGauge(
          "sinew_distillation_latent_kl_nats",
          "Mean KL of posterior and prior in the latest update.")),
      distillation_continuity_loss(registry.AddGauge(
          "sinew_distillation_continuity_loss",
          "Mean distance of consecutive posterior means, as the loss has it, "
          "in the latest update.")),
      memory_rows(registry.AddGauge("sinew_memory_rows",
                                    "Labelled rows kept to learn from.")),
      labelled_rows(registry.AddCounter("sinew_labelled_rows_total",
                                        "Rows that a teacher labelled.")),
      evaluation_success_ratio(
          registry.AddGauge("sinew_evaluation_success_ratio",
                            "Share of evaluation starts that survived.")) {}

}  // namespace sinew::metrics
