#include "tools/training/metrics_log.h"

#include <nlohmann/json.hpp>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"
#include "common/files.h"
#include "common/status_macros.h"
#include "tools/curriculum/summary_json.h"

namespace sinew::tools {
namespace {

using Json = nlohmann::ordered_json;

// What no frame was measured for is null.
Json Mean(double value, int64_t frames) {
  return frames > 0 ? Json(value) : Json(nullptr);
}

Json SetRow(const SetSummary& set) {
  const MetricMeans& means = set.means;
  return {{"clips", set.clips},
          {"succeeded_clips", set.succeeded_clips},
          {"starts", set.starts},
          {"succeeded_starts", set.succeeded_starts},
          {"survived_share", set.survived_share},
          {"e_g_mpjpe_mm", Mean(means.e_g_mpjpe_mm, set.frames)},
          {"e_mpjpe_mm", Mean(means.e_mpjpe_mm, set.frames)},
          {"e_vel", Mean(means.e_vel, means.velocity_frames)},
          {"e_acc", Mean(means.e_acc, means.acceleration_frames)}};
}

Json EvaluationRow(const learner::IterationReport& report) {
  const EvaluationSummary& evaluation = *report.evaluation;
  Json row = {{"iteration", report.evaluated_iteration}};
  row.update(SetRow(evaluation.overall));
  if (evaluation.left_out.clips > 0) {
    row["training"] = SetRow(evaluation.training);
    row["left_out"] = SetRow(evaluation.left_out);
  }
  if (report.drawn.clips < evaluation.training.clips) {
    row["drawn"] = SetRow(report.drawn);
  }
  return row;
}

Json SecondsRow(const learner::IterationReport& report,
                const RunFigures& figures) {
  const v1::StageSeconds& rollout = report.rollout_seconds;
  return {{"iteration", figures.iteration_wall},
          {"wait", report.wait_seconds},
          {"label", report.label_seconds},
          {"learn", report.learn_seconds},
          {"publish", report.publish_seconds},
          {"save", figures.save_seconds},
          {"simulate", rollout.simulate()},
          {"infer", rollout.infer()},
          {"observe", rollout.observe()},
          {"encode", rollout.encode()},
          {"evaluate", report.evaluation_core_seconds},
          {"learner_cpu", figures.learner_cpu},
          {"actors_cpu", figures.actors_cpu}};
}

Json UpdateRow(const learner::UpdateStatistics& update) {
  return {{"policy_loss", update.policy_loss},
          {"value_loss", update.value_loss},
          {"kl", update.kl},
          {"epochs", update.epochs},
          {"clip_fraction", update.clip_fraction},
          {"policy_gradient_norm", update.policy_gradient_norm},
          {"value_gradient_norm", update.value_gradient_norm},
          {"explained_variance", update.explained_variance},
          {"policy_learning_rate", update.policy_learning_rate},
          {"value_learning_rate", update.value_learning_rate},
          {"std_factor", update.std_factor},
          {"non_finite", update.non_finite}};
}

Json DistillationRow(const learner::DistillationFigures& figures) {
  return {{"action_loss", figures.action_loss},
          {"action_error_rad", figures.action_error_rad},
          {"latent_kl", figures.latent_kl},
          {"continuity_loss", figures.continuity_loss},
          {"kl_weight", figures.kl_weight},
          {"memory_rows", figures.memory_rows},
          {"labelled_rows", figures.labelled_rows}};
}

Json Row(const learner::IterationReport& report, const RunFigures& figures) {
  const RunSeconds& seconds = figures.seconds;
  const learner::UpdateStatistics& update = report.update;
  Json row = {{"iteration", report.iteration},
              {"wall_s", seconds.wall},
              {"train_s", seconds.train},
              {"samples", report.samples},
              {"policy_version", report.policy_version},
              {"reward", update.reward_mean},
              {"reward_terms", update.reward_terms},
              {"body_distance_m", update.body_distance_mean_m},
              {"episodes", report.episodes},
              {"failed_episodes", report.failed_episodes},
              {"carried_episodes", report.carried_episodes},
              {"episode_steps", report.mean_episode_steps},
              {"diverged", report.diverged}};
  row.update(UpdateRow(update));
  const Json rest = {{"policy_lag", report.policy_lag},
                     {"physics_steps", report.physics_steps},
                     {"cores", figures.cores},
                     {"ranks", figures.ranks},
                     {"actors", figures.actors},
                     {"orders_reissued", figures.orders_reissued},
                     {"save_failures", figures.save_failures},
                     {"flops", update.flops},
                     {"seconds", SecondsRow(report, figures)}};
  row.update(rest);
  row["curriculum"] = SummaryJson(report.curriculum);
  if (update.latent_kl) row["latent_kl"] = *update.latent_kl;
  if (update.distillation) {
    row["distillation"] = DistillationRow(*update.distillation);
  }
  if (report.plateau) {
    row["plateau"] = {{"best_share", report.plateau->best_share()},
                      {"stalled", report.plateau->stalled()}};
  }
  if (report.evaluation) row["eval"] = EvaluationRow(report);
  return row;
}

// The rows up to `iteration`.
std::string KeptRows(const std::string& text, int64_t iteration) {
  std::string kept;
  for (absl::string_view line : absl::StrSplit(text, '\n', absl::SkipEmpty())) {
    const Json row = Json::parse(line.begin(), line.end(), nullptr,
                                 /*allow_exceptions=*/false);
    if (!row.is_object() || row.value("iteration", int64_t{0}) > iteration) {
      break;
    }
    absl::StrAppend(&kept, line, "\n");
  }
  return kept;
}

}  // namespace

absl::StatusOr<std::unique_ptr<MetricsLog>> MetricsLog::Open(
    const std::string& path, int64_t iteration) {
  std::string kept;
  if (FileExists(path)) {
    SINEW_ASSIGN_OR_RETURN(const std::string text, ReadFile(path));
    kept = KeptRows(text, iteration);
  }
  SINEW_RETURN_IF_ERROR(WriteFileAtomically(path, kept));
  auto log = std::unique_ptr<MetricsLog>(new MetricsLog(path));
  log->stream_.open(path, std::ios::app);
  if (!log->stream_) {
    return absl::UnavailableError(absl::StrCat(path, ": cannot be opened"));
  }
  return log;
}

absl::Status MetricsLog::Write(const learner::IterationReport& report,
                               const RunFigures& figures) {
  stream_ << Row(report, figures).dump() << std::endl;
  if (stream_) return absl::OkStatus();
  stream_.clear();
  return absl::ResourceExhaustedError(
      absl::StrCat(path_, ": cannot write a row; is the disk full?"));
}

}  // namespace sinew::tools
