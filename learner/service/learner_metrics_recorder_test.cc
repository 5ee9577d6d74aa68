#include "learner/service/learner_metrics_recorder.h"

#include <string>

#include "common/metrics/learner_metrics.h"
#include "common/metrics/registry.h"
#include "common/metrics/testing/lint.h"
#include "common/testing/matchers.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace sinew::learner {
namespace {

using ::sinew::testing::IsOk;
using ::testing::HasSubstr;

struct Fixture {
  metrics::Registry registry{{.role = "learner", .build = "b1"}};
  metrics::LearnerMetrics metrics{registry};
  LearnerMetricsRecorder recorder{metrics};

  // Expects the line `series value` in a scrape.
  void Expect(const std::string& line) {
    EXPECT_THAT(registry.Text(), HasSubstr("\n" + line + "\n"));
  }
};

IterationReport MakeReport() {
  IterationReport report;
  report.iteration = 7;
  report.policy_version = 7;
  report.segments = 16;
  report.policy_lag = 1;
  report.update.samples = 8000;
  report.update.kl = 0.25;
  report.update.clip_fraction = 0.125;
  report.update.policy_gradient_norm = 0.5;
  report.update.value_gradient_norm = 2;
  report.update.non_finite = 1;
  report.update.reward_mean = 0.75;
  report.failed_episodes = 4;
  report.time_limit_episodes = 3;
  report.clip_end_episodes = 2;
  report.diverged = 1;
  report.physics_steps = 32000;
  report.wait_seconds = 1.5;
  report.learn_seconds = 2.5;
  report.publish_seconds = 0.25;
  report.evaluation_core_seconds = 4;
  return report;
}

TEST(LearnerMetricsRecorder, ShowsADistillation) {
  Fixture f;
  IterationReport report = MakeReport();
  report.label_seconds = 0.5;
  report.update.distillation = DistillationFigures{.action_error_rad = 0.125,
                                                   .latent_kl = 3,
                                                   .continuity_loss = 0.25,
                                                   .memory_rows = 4096,
                                                   .labelled_rows = 1000};

  f.recorder.RecordIteration(report);
  f.recorder.RecordIteration(report);

  f.Expect("sinew_distillation_action_error_radians 0.125");
  f.Expect("sinew_distillation_latent_kl_nats 3");
  f.Expect("sinew_distillation_continuity_loss 0.25");
  f.Expect("sinew_memory_rows 4096");
  f.Expect("sinew_labelled_rows_total 2000");
  f.Expect("sinew_stage_seconds_total{stage=\"label\"} 1");
}

TEST(LearnerMetricsRecorder, ShowsWhatAnIterationDid) {
  Fixture f;

  f.recorder.RecordIteration(MakeReport());
  f.recorder.RecordIteration(MakeReport());

  f.Expect("sinew_iterations_total 2");
  f.Expect("sinew_samples_total 16000");
  f.Expect("sinew_physics_steps_total 64000");
  f.Expect("sinew_policy_version 7");
  f.Expect("sinew_stage_seconds_total{stage=\"wait\"} 3");
  f.Expect("sinew_stage_seconds_total{stage=\"learn\"} 5");
  f.Expect("sinew_stage_seconds_total{stage=\"publish\"} 0.5");
  f.Expect("sinew_stage_seconds_total{stage=\"evaluate\"} 8");
  f.Expect("sinew_policy_lag_versions_bucket{le=\"0\"} 0");
  f.Expect("sinew_policy_lag_versions_bucket{le=\"1\"} 32");
  f.Expect("sinew_episode_ends_total{reason=\"terminated\"} 8");
  f.Expect("sinew_episode_ends_total{reason=\"time_limit\"} 6");
  f.Expect("sinew_episode_ends_total{reason=\"clip_end\"} 4");
  f.Expect("sinew_episode_ends_total{reason=\"diverged\"} 2");
  f.Expect("sinew_kl_divergence 0.25");
  f.Expect("sinew_clipped_ratio 0.125");
  f.Expect("sinew_gradient_norm{network=\"policy\"} 0.5");
  f.Expect("sinew_gradient_norm{network=\"value\"} 2");
  f.Expect("sinew_non_finite_total 2");
  f.Expect("sinew_mean_reward 0.75");
}

TEST(LearnerMetricsRecorder, KeepsTheSuccessOfTheLatestEvaluation) {
  Fixture f;
  IterationReport evaluated = MakeReport();
  evaluated.evaluation.emplace();
  evaluated.evaluation->overall.starts = 32;
  evaluated.evaluation->overall.succeeded_starts = 8;

  f.recorder.RecordIteration(evaluated);
  f.recorder.RecordIteration(MakeReport());

  f.Expect("sinew_evaluation_success_ratio 0.25");
}

TEST(LearnerMetricsRecorder, MovesCountersByWhatTheDispatcherAdds) {
  Fixture f;
  Dispatcher::Statistics statistics;
  statistics.actors = 3;
  statistics.refused_actors = 1;
  statistics.lost_actors = 2;
  statistics.orders_waiting = 5;
  statistics.orders_leased = 6;
  statistics.orders_reissued = 7;
  statistics.orders_returned = 8;
  statistics.applied_version = 41;

  f.recorder.RecordActors(statistics);
  statistics.orders_reissued = 9;
  f.recorder.RecordActors(statistics);

  f.Expect("sinew_actors_connected 3");
  f.Expect("sinew_actors_refused_total 1");
  f.Expect("sinew_actors_lost_total 2");
  f.Expect("sinew_orders_waiting 5");
  f.Expect("sinew_orders_outstanding 6");
  f.Expect("sinew_orders_reissued_total 9");
  f.Expect("sinew_orders_returned_total 8");
  f.Expect("sinew_applied_policy_version 41");
}

TEST(LearnerMetricsRecorder, ObservesEveryApply) {
  Fixture f;
  const auto observe = ObserveApply(f.metrics);

  observe(0.0005);
  observe(100);

  f.Expect("sinew_publish_to_apply_seconds_bucket{le=\"0.001\"} 1");
  f.Expect("sinew_publish_to_apply_seconds_count 2");
}

TEST(LearnerMetricsRecorder, AddsSavingToTheTimeOfTheLoop) {
  Fixture f;

  f.recorder.RecordSaveSeconds(0.5);
  f.recorder.RecordSaveSeconds(0.25);

  f.Expect("sinew_stage_seconds_total{stage=\"checkpoint\"} 0.75");
}

TEST(LearnerMetricsRecorder, ItsSeriesKeepToPrometheusRules) {
  Fixture f;
  f.recorder.RecordIteration(MakeReport());

  EXPECT_THAT(metrics::Lint(f.registry.Text()), IsOk());
}

}  // namespace
}  // namespace sinew::learner
