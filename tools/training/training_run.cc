#include "tools/training/training_run.h"

#include <unistd.h>

#include <algorithm>
#include <string>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "common/build_info.h"
#include "common/cpu.h"
#include "common/files.h"
#include "common/logging.h"
#include "common/status_macros.h"
#include "deploy/bundle/run_export.h"
#include "proto/sinew/v1/training_state.pb.h"
#include "tools/training/bundle_metrics.h"
#include "tools/training/process_cpu.h"

namespace sinew::tools {
namespace {

// For the last save; a store gives up earlier.
constexpr absl::Duration kSaveTimeout = absl::Minutes(10);

double Limit(double asked, double of_recipe) {
  return asked > 0 ? asked : of_recipe;
}

std::string EvaluationText(const SetSummary& overall) {
  return absl::StrFormat(
      "%d/%d starts (%.0f %% survived) %.0f mm", overall.succeeded_starts,
      overall.starts, 100 * overall.survived_share, overall.means.e_g_mpjpe_mm);
}

}  // namespace

std::string TrainingRun::EndReason() const {
  if (trainer_->plateau_ends_it()) {
    const v1::PlateauState& plateau = trainer_->plateau();
    return absl::StrFormat(
        "plateau: %d evaluations without a gain above %.1f %% of starts",
        plateau.stalled(), 100 * plateau.best_share());
  }
  const double iterations =
      Limit(static_cast<double>(options_.iterations),
            static_cast<double>(options_.recipe.max_iterations()));
  if (iterations > 0 &&
      static_cast<double>(trainer_->iteration()) >= iterations) {
    return "iterations";
  }
  const double minutes = Limit(options_.minutes, options_.recipe.max_minutes());
  if (minutes > 0 && figures_.seconds.train >= 60 * minutes) return "minutes";
  return "";
}

TrainingRun::Result TrainingRun::result() const {
  const int64_t last = options_.recipe.max_iterations();
  Result result;
  result.iterations = trainer_->iteration();
  result.samples = trainer_->samples();
  result.train_seconds = figures_.seconds.train;
  result.plateau = trainer_->plateau_ends_it();
  result.best_share = trainer_->plateau().best_share();
  result.stalled = trainer_->plateau().stalled();
  result.finished =
      result.plateau || (last > 0 && trainer_->iteration() >= last);
  return result;
}

absl::Status TrainingRun::Train() {
  row_seconds_ = clock_.SteadySeconds();
  row_learner_cpu_ = ProcessCpuSeconds(getpid());
  row_actors_cpu_ = children_.cpu_seconds ? children_.cpu_seconds() : 0;
  if (IsDone()) {
    LogInfo("nothing is left to train", {{"reason", EndReason()}});
  }
  absl::Status status;
  while (status.ok() && !IsDone() && !stop_.stop_requested()) {
    status = RunIteration();
  }
  if (absl::IsCancelled(status) && stop_.stop_requested()) {
    status = absl::OkStatus();
  }
  if (stop_.stop_requested()) LogInfo("stopping: saving what there is");
  if (trainer_->at_rest()) {
    status.Update(SaveAndWait());
    status.Update(Export());
  }
  experience_->End();
  const std::string reason = !status.ok() ? "failed"
                             : IsDone()   ? EndReason()
                                          : "stopped";
  LogInfo("training has ended", {{"iteration", trainer_->iteration()},
                                 {"train_s", figures_.seconds.train},
                                 {"reason", reason}});
  return status;
}

absl::Status TrainingRun::RunIteration() {
  SINEW_ASSIGN_OR_RETURN(const learner::IterationReport report,
                         trainer_->RunIteration());
  Account(report);
  if (report.evaluation) {
    metrics_ =
        MakeBundleMetrics(*report.evaluation, report.evaluated_iteration);
  }
  // Actors work while this process writes.
  if (!IsDone() && !stop_.stop_requested()) {
    SINEW_RETURN_IF_ERROR(trainer_->BeginNext());
  }
  KeepBest(report);
  Tell(report);
  Show(report);
  SaveByInterval();
  return absl::OkStatus();
}

void TrainingRun::Account(const learner::IterationReport& report) {
  const double now = clock_.SteadySeconds();
  const double learner_cpu = ProcessCpuSeconds(getpid());
  const auto actors = services_->server().dispatcher().statistics();
  figures_.iteration_wall = now - row_seconds_;
  figures_.learner_cpu = learner_cpu - row_learner_cpu_;
  figures_.cores = options_.cores;
  figures_.ranks = options_.ranks;
  figures_.actors = actors.actors;
  figures_.orders_reissued = actors.orders_reissued;
  row_seconds_ = now;
  row_learner_cpu_ = learner_cpu;
  if (children_.cpu_seconds) {
    const double cpu = children_.cpu_seconds();
    figures_.actors_cpu = cpu - row_actors_cpu_;
    row_actors_cpu_ = cpu;
  }
  const double threads = static_cast<double>(std::max<int64_t>(
      1, actors.threads > 0 ? actors.threads : options_.cores));
  figures_.seconds.wall += figures_.iteration_wall;
  figures_.seconds.train += std::max(
      0.0, figures_.iteration_wall - report.evaluation_core_seconds / threads);
}

void TrainingRun::Tell(const learner::IterationReport& report) {
  const absl::Status written = metrics_log_->Write(report, figures_);
  if (!written.ok()) LogError(written.message());
  services_->recorder().RecordIteration(report);
  services_->recorder().RecordSaveSeconds(figures_.save_seconds);
  figures_.save_seconds = 0;
}

void TrainingRun::Show(const learner::IterationReport& report) {
  if (report.evaluation) {
    evaluation_ = EvaluationText(report.evaluation->overall);
    progress_.Line(absl::StrFormat("iteration %d  train %.0f s  samples %d  %s",
                                   report.iteration, figures_.seconds.train,
                                   report.samples, evaluation_));
  }
  ProgressState state;
  state.iteration = report.iteration;
  state.samples = report.samples;
  const double session = figures_.seconds.train - first_train_seconds_;
  state.samples_per_second =
      session > 0
          ? static_cast<double>(report.samples - first_samples_) / session
          : 0;
  state.reward = report.update.reward_mean;
  if (report.update.distillation) {
    state.action_error_rad = report.update.distillation->action_error_rad;
  }
  state.evaluation = evaluation_;
  SetEnd(state);
  if (figures_.save_failures > 0) {
    state.trouble =
        absl::StrCat(figures_.save_failures, " saves have failed, see log");
  }
  progress_.Show(state);
}

void TrainingRun::SetEnd(ProgressState& state) const {
  const double iterations =
      Limit(static_cast<double>(options_.iterations),
            static_cast<double>(options_.recipe.max_iterations()));
  const double seconds =
      60 * Limit(options_.minutes, options_.recipe.max_minutes());
  const double trained = figures_.seconds.train;
  double share = 0;
  if (iterations > 0) {
    share = static_cast<double>(trainer_->iteration()) / iterations;
  }
  if (seconds > 0) share = std::max(share, trained / seconds);
  if (share <= 0) return;
  state.share = std::min(1.0, share);
  state.seconds_left = trained * (1 / *state.share - 1);
}

learner::Trainer::State TrainingRun::State() const {
  learner::Trainer::State state = trainer_->Save();
  state.counters.set_build(BuildIdentity());
  state.counters.set_cpu_class(CpuClass());
  state.counters.set_wall_seconds(figures_.seconds.wall);
  state.counters.set_train_seconds(figures_.seconds.train);
  if (metrics_) *state.counters.mutable_metrics() = *metrics_;
  return state;
}

absl::Status TrainingRun::TakeSaveResult() {
  const auto result = saver_->TakeResult();
  if (!result) return absl::OkStatus();
  figures_.save_seconds += result->seconds;
  if (result->status.ok()) {
    saved_iteration_ = result->iteration;
  } else {
    ++figures_.save_failures;
  }
  return result->status;
}

void TrainingRun::SaveByInterval() {
  TakeSaveResult().IgnoreError();  // logged by the saver, counted here
  if (trainer_->iteration() % options_.recipe.checkpointing().interval() == 0) {
    save_is_due_ = true;
  }
  // One at a time: while the disk is slower than training, some are left out.
  if (save_is_due_ && saver_->idle() && saver_->Start(State())) {
    save_is_due_ = false;
  }
}

absl::Status TrainingRun::SaveAndWait() {
  SINEW_RETURN_IF_ERROR(saver_->Flush(kSaveTimeout));
  TakeSaveResult().IgnoreError();
  if (saved_iteration_ == trainer_->iteration()) return absl::OkStatus();
  saver_->Start(State());
  SINEW_RETURN_IF_ERROR(saver_->Flush(kSaveTimeout));
  return TakeSaveResult();
}

void TrainingRun::KeepBest(const learner::IterationReport& report) {
  best_->Remember(
      report.iteration,
      std::make_shared<const std::string>(trainer_->snapshot().bytes),
      report.samples, figures_.seconds.train);
  const absl::Status kept = best_->Observe(report);
  if (kept.ok()) return;
  ++figures_.save_failures;
  LogError("the best policy cannot be kept", {{"reason", kept.message()}});
}

absl::Status TrainingRun::Export() const {
  if (trainer_->iteration() == 0) return absl::OkStatus();
  bundle::RunResult last;
  last.snapshot = trainer_->snapshot().bytes;
  last.iterations = trainer_->iteration();
  last.samples = trainer_->samples();
  last.train_seconds = figures_.seconds.train;
  last.build = BuildIdentity();
  last.metrics = metrics_;
  SINEW_RETURN_IF_ERROR(
      bundle::ExportRun(folder_->path(), last, folder_->bundle()));
  if (!best_->best()) {
    // What was the best on another library is none here.
    if (best_->is_of_others()) {
      SINEW_RETURN_IF_ERROR(RemoveRecursively(folder_->best_bundle()));
    }
    if (FileExists(folder_->best_bundle())) {
      LogWarning(
          "the best policy is missing where states are: bundle_best "
          "stays as it was");
    } else {
      LogInfo("nothing was evaluated: no bundle_best");
    }
    return absl::OkStatus();
  }
  const v1::EvaluatedPolicy& evaluated = best_->best()->evaluated;
  bundle::RunResult best;
  best.snapshot = *best_->best()->snapshot;
  best.iterations = evaluated.iteration();
  best.samples = evaluated.samples();
  best.train_seconds = evaluated.train_seconds();
  best.build = evaluated.build();
  best.metrics = evaluated.metrics();
  return bundle::ExportRun(folder_->path(), best, folder_->best_bundle());
}

}  // namespace sinew::tools
