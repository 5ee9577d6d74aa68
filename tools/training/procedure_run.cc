#include "tools/training/procedure_run.h"

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <iterator>
#include <memory>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "absl/container/flat_hash_set.h"
#include "absl/strings/str_cat.h"
#include "common/config/recipe.h"
#include "common/digest.h"
#include "common/files.h"
#include "common/logging.h"
#include "common/replace_directory.h"
#include "common/status_macros.h"
#include "deploy/bundle/manifest.h"
#include "learner/procedure/procedure.h"
#include "learner/procedure/stage_recipe.h"
#include "tools/evaluation/evaluation.h"
#include "tools/training/procedure_bounds.h"
#include "tools/training/procedure_inputs.h"
#include "tools/training/procedure_record.h"
#include "tools/training/run_folder.h"
#include "tools/training/task_setup.h"

namespace sinew::tools {
namespace {

constexpr char kEvaluation[] = "eval.json";

// Copies a folder so that `to` is at any moment the old one or the whole new
// one.
absl::Status CopyFolder(const std::string& from, const std::string& to) {
  const std::string aside = absl::StrCat(to, ".part");
  SINEW_RETURN_IF_ERROR(RemoveRecursively(aside));
  std::error_code error;
  std::filesystem::copy(from, aside, std::filesystem::copy_options::recursive,
                        error);
  if (error) {
    return absl::InternalError(absl::StrCat(from, ": cannot be copied to ",
                                            aside, ": ", error.message()));
  }
  return ReplaceDirectory(aside, to);
}

absl::Status CheckOptions(const TrainingRun::Options& options) {
  if (options.migrate_library) {
    return absl::InvalidArgumentError(
        "--migrate-library: expected a run of one training, found a procedure, "
        "whose finished stages are about the library that it began with");
  }
  if (!options.primitives.empty()) {
    return absl::InvalidArgumentError(
        "--primitives: expected a recipe with network.composer, found one with "
        "a procedure, which trains its primitives itself");
  }
  if (!options.continue_from.empty()) {
    return absl::InvalidArgumentError(
        "--continue: expected a recipe of one training, found a procedure, "
        "whose stages begin with each other's weights");
  }
  for (const auto& [flag, names] :
       {std::pair("--teacher", &options.teachers),
        std::pair("--teacher-eval", &options.teacher_evaluations)}) {
    if (names->empty()) continue;
    return absl::InvalidArgumentError(absl::StrCat(
        flag,
        ": expected a recipe with distillation, found one with a procedure, "
        "whose stages learn without a teacher"));
  }
  for (const auto& [flag, address] :
       {std::pair("--replay", &options.replay_address),
        std::pair("--checkpoint", &options.checkpoint_address)}) {
    if (address->empty()) continue;
    return absl::InvalidArgumentError(absl::StrCat(
        flag,
        ": expected none with a procedure, whose stages have a table and "
        "a store each, found ",
        *address));
  }
  return learner::ValidateStages(options.recipe);
}

class ProcedureRun {
 public:
  // `folder` is locked while this lives; borrows the steps.
  ProcedureRun(const TrainingRun::Options& options, const ProcedureSteps& steps,
               const StopToken& stop, ProcedureInputs inputs,
               std::unique_ptr<RunFolder> folder)
      : options_(options),
        steps_(steps),
        stop_(stop),
        inputs_(std::move(inputs)),
        folder_(std::move(folder)),
        record_(inputs_.record) {}

  absl::Status Load();
  absl::Status Run();

 private:
  std::string StagePath(int stage, const std::string& name) const;
  absl::Status Save() const;
  // False: there is no next stage.
  absl::StatusOr<bool> Decide();
  // False: it is to go on with the next call.
  absl::StatusOr<bool> RunStage();
  TrainingRun::Options StageOptions(int stage) const;
  absl::StatusOr<evaluation::EvaluationFigures> Evaluate(
      int stage, const v1::Recipe& recipe) const;
  // Those trained on that it does not win.
  absl::StatusOr<std::vector<std::string>> FailedClips(
      const EvaluationSummary& summary) const;
  // The policy that the procedure came to becomes the run's.
  absl::Status KeepResult() const;
  absl::Status End();

  const TrainingRun::Options& options_;
  const ProcedureSteps& steps_;
  const StopToken stop_;
  const ProcedureInputs inputs_;
  const std::unique_ptr<RunFolder> folder_;
  ProcedureRecord record_;
  std::string bound_;  // that is reached, in words; empty: none
};

absl::Status ProcedureRun::Load() {
  const std::string file = folder_->procedure();
  if (!FileExists(file)) return inputs_.clean;
  SINEW_ASSIGN_OR_RETURN(const std::string text, ReadFile(file));
  SINEW_ASSIGN_OR_RETURN(ProcedureRecord before, ParseProcedure(text, file));
  // Of a procedure that trained nothing yet: this one begins instead.
  if (before.Finished().empty() && !RunFolder::HasState(folder_->path())) {
    return inputs_.clean;
  }
  SINEW_RETURN_IF_ERROR(CheckSameInputs(before, record_, folder_->path()));
  record_ = std::move(before);
  record_.end.reset();
  return CheckFollows(record_, options_.recipe.procedure(), inputs_.trained_on,
                      file);
}

absl::Status ProcedureRun::Save() const {
  return WriteFileAtomically(folder_->procedure(), PrintProcedure(record_));
}

absl::Status ProcedureRun::Run() {
  while (!stop_.stop_requested()) {
    SINEW_ASSIGN_OR_RETURN(const bool more, Decide());
    if (!more) return End();
    const absl::StatusOr<bool> done = RunStage();
    if (absl::IsCancelled(done.status()) && stop_.stop_requested()) break;
    SINEW_RETURN_IF_ERROR(done.status());
    if (!*done) break;
  }
  LogInfo("the procedure is not over; the same command goes on with it",
          {{"reason", bound_.empty() ? "stopped" : bound_}});
  return absl::OkStatus();
}

absl::StatusOr<bool> ProcedureRun::Decide() {
  const std::vector<learner::FinishedStage> finished = record_.Finished();
  learner::Decision decision = learner::NextStage(options_.recipe.procedure(),
                                                  inputs_.trained_on, finished);
  if (!decision.next) {
    record_.end = std::move(decision);
    return false;
  }
  const size_t index = finished.size();
  if (index < record_.stages.size()) return true;
  const std::string directory =
      StageDirectory(*decision.next, static_cast<int>(index));
  // Nothing that is still to come can change it.
  if (decision.next->kind == learner::StageKind::kSingle) {
    SINEW_RETURN_IF_ERROR(KeepResult());
  }
  LogInfo("stage begins", {{"stage", directory}, {"reason", decision.reason}});
  record_.stages.push_back({.directory = directory,
                            .decision = std::move(decision),
                            .finished = {},
                            .recovered = {}});
  SINEW_RETURN_IF_ERROR(Save());
  return true;
}

std::string ProcedureRun::StagePath(int stage, const std::string& name) const {
  return JoinPath(JoinPath(folder_->path(), record_.stages[stage].directory),
                  name);
}

TrainingRun::Options ProcedureRun::StageOptions(int stage) const {
  const learner::Stage& what = *record_.stages[stage].decision.next;
  TrainingRun::Options options = options_;
  options.recipe = learner::StageRecipe(options_.recipe, what, stage);
  options.directory =
      JoinPath(folder_->path(), record_.stages[stage].directory);
  options.minutes = 0;
  options.iterations = 0;
  if (what.kind != learner::StageKind::kFull) options.init.clear();
  if (what.from >= 0) {
    options.init = StagePath(what.from, "bundle");
    options.init_critic = StagePath(what.from, "checkpoints");
    options.init_critic_iteration =
        record_.stages[what.from].finished->iterations;
  }
  for (const int primitive : what.primitives) {
    options.primitives.push_back(StagePath(primitive, "bundle"));
  }
  return options;
}

absl::StatusOr<bool> ProcedureRun::RunStage() {
  const int index = static_cast<int>(record_.stages.size()) - 1;
  TrainingRun::Options options = StageOptions(index);
  ProcedureBounds bounds = BoundsAfter(options_, record_.Finished());
  bound_ = bounds.Reached();
  if (!bound_.empty()) return false;
  bounds.Limit(options);
  SINEW_RETURN_IF_ERROR(CheckSameLibrary(record_, options_.motions));
  SINEW_ASSIGN_OR_RETURN(const TrainingRun::Result result,
                         steps_.train(options));
  if (!result.finished || stop_.stop_requested()) {
    bounds.Spend(result.train_seconds, result.iterations);
    bound_ = bounds.Reached();
    return false;
  }
  learner::FinishedStage finished;
  finished.stage = *record_.stages[index].decision.next;
  finished.plateau = result.plateau;
  finished.iterations = result.iterations;
  finished.samples = result.samples;
  finished.train_seconds = result.train_seconds;
  finished.best_share = result.best_share;
  finished.stalled = result.stalled;
  SINEW_ASSIGN_OR_RETURN(const evaluation::EvaluationFigures figures,
                         Evaluate(index, options.recipe));
  SINEW_ASSIGN_OR_RETURN(finished.failed, FailedClips(figures.policy));
  if (figures.fallen) {
    // As it was trained: on get-ups alone, or beside clips that stand.
    const bool on_get_ups =
        options.recipe.task().recovery().fallen_share() == 0 &&
        figures.fallen->get_up.has_value();
    const evaluation::FallenFigures& fallen =
        on_get_ups ? figures.fallen->get_up->policy : figures.fallen->policy;
    record_.stages[index].recovered = {.starts = figures.fallen->starts,
                                       .within_3_s = fallen.recovered_3_s,
                                       .within_5_s = fallen.recovered_5_s};
    LogInfo("fallen starts", {{"stage", record_.stages[index].directory},
                              {"starts", figures.fallen->starts},
                              {"on_get_ups", on_get_ups},
                              {"within_3_s", fallen.recovered_3_s},
                              {"within_5_s", fallen.recovered_5_s}});
  }
  LogInfo("stage has ended", {{"stage", record_.stages[index].directory},
                              {"samples", finished.samples},
                              {"clips", inputs_.trained_on.size()},
                              {"failed", finished.failed.size()}});
  record_.stages[index].finished = std::move(finished);
  SINEW_RETURN_IF_ERROR(Save());
  return true;
}

absl::StatusOr<evaluation::EvaluationFigures> ProcedureRun::Evaluate(
    int stage, const v1::Recipe& recipe) const {
  SINEW_RETURN_IF_ERROR(CheckSameLibrary(record_, options_.motions));
  evaluation::EvaluationOptions options;
  options.starts = options_.recipe.evaluation().starts();
  options.seconds = options_.recipe.evaluation().seconds();
  options.threads = options_.cores;
  const auto evaluate = [&] {
    return steps_.evaluate(StagePath(stage, "bundle"), options_.motions,
                           StagePath(stage, kEvaluation), options);
  };
  if (FallenShare(recipe.task().recovery()) > 0) {
    options.fallen = kProcedureFallenStarts;
    auto figures = evaluate();
    if (!absl::IsNotFound(figures.status())) return figures;
    // No clip to stand up beside: then the stage goes on without this figure.
    LogWarning("fallen starts are not evaluated",
               {{"reason", figures.status().message()}});
    options.fallen.reset();
  }
  return evaluate();
}

absl::StatusOr<std::vector<std::string>> ProcedureRun::FailedClips(
    const EvaluationSummary& summary) const {
  absl::flat_hash_set<std::string> won;
  for (const ClipSummary& clip : summary.clips) {
    if (clip.clip < 0 || clip.clip >= std::ssize(inputs_.clips)) {
      return absl::FailedPreconditionError(absl::StrCat(
          options_.motions, ": expected the ", inputs_.clips.size(),
          " clips that the procedure was started with, found clip ",
          clip.clip));
    }
    if (clip.success) won.insert(inputs_.clips[clip.clip]);
  }
  std::vector<std::string> failed = inputs_.trained_on;
  std::erase_if(failed, [&](const auto& name) { return won.contains(name); });
  return failed;
}

absl::Status ProcedureRun::KeepResult() const {
  const int result = learner::ResultStage(record_.Finished());
  SINEW_RETURN_IF_ERROR(
      CopyFolder(StagePath(result, "bundle"), folder_->bundle()));
  SINEW_ASSIGN_OR_RETURN(const std::string evaluated,
                         ReadFile(StagePath(result, kEvaluation)));
  return WriteFileAtomically(JoinPath(folder_->path(), kEvaluation), evaluated);
}

absl::Status ProcedureRun::End() {
  SINEW_RETURN_IF_ERROR(KeepResult());
  if (const auto both = learner::Compare(record_.Finished())) {
    LogInfo("the procedure beside a single primitive",
            {{"clips", inputs_.trained_on.size()},
             {"procedure_samples", both->procedure.samples},
             {"procedure_failed", both->procedure.failed},
             {"single_samples", both->single.samples},
             {"single_failed", both->single.failed}});
  }
  LogInfo("the procedure has ended", {{"reason", record_.end->reason}});
  return Save();
}

// A stage by which the whole task can be set up: the one that recovers, if it
// needs get-ups of the library, so that a library without one is refused at
// once, and not after all stages before it. Nobody needs to fall for it.
v1::Recipe TaskOf(const v1::Recipe& recipe) {
  learner::Stage stage;
  if (recipe.procedure().recovery_samples() > 0 &&
      recipe.task().recovery().get_up_share() > 0) {
    stage.kind = learner::StageKind::kRecovery;
  }
  v1::Recipe derived = learner::StageRecipe(recipe, stage, 0);
  if (derived.task().has_recovery()) {
    derived.mutable_task()->mutable_recovery()->set_fallen_share(0);
  }
  return derived;
}

// SHA-256 of the manifest of the bundle that --init names; empty without one,
// and where a procedure that has begun names one that is gone.
absl::StatusOr<std::string> InitDigest(const TrainingRun::Options& options) {
  if (options.init.empty()) return "";
  const auto manifest = ReadFile(JoinPath(options.init, bundle::kManifestFile));
  if (absl::IsNotFound(manifest.status()) &&
      FileExists(RunFolder::ProcedureOf(options.directory))) {
    return "";
  }
  SINEW_RETURN_IF_ERROR(manifest.status());
  return Sha256Hex(*manifest);
}

// What it is about; the assets themselves are given up.
absl::StatusOr<ProcedureInputs> ReadInputs(
    const TrainingRun::Options& options) {
  SINEW_ASSIGN_OR_RETURN(
      const TaskSetup setup,
      SetUpTask(TaskOf(options.recipe), options.character, options.motions));
  SINEW_ASSIGN_OR_RETURN(const std::string init, InitDigest(options));
  ProcedureInputs inputs = MakeProcedureInputs(options.recipe, setup, init);
  inputs.clean = CheckClean(setup.library->manifest());
  SINEW_ASSIGN_OR_RETURN(
      inputs.record.cleaned_away,
      CleanedAway(options.motions, inputs.record.library_clips));
  return inputs;
}

}  // namespace

absl::Status RunProcedure(const TrainingRun::Options& options,
                          const ProcedureSteps& steps, const StopToken& stop) {
  SINEW_RETURN_IF_ERROR(CheckOptions(options));
  SINEW_ASSIGN_OR_RETURN(ProcedureInputs inputs, ReadInputs(options));
  SINEW_ASSIGN_OR_RETURN(std::unique_ptr<RunFolder> folder,
                         RunFolder::Open(options.directory, options.recipe));
  // Its states are in the folder, where Open has looked.
  SINEW_RETURN_IF_ERROR(folder->WriteConfig(options.recipe, ""));
  ProcedureRun run(options, steps, stop, std::move(inputs), std::move(folder));
  SINEW_RETURN_IF_ERROR(run.Load());
  return run.Run();
}

}  // namespace sinew::tools
