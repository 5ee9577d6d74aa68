#include <unistd.h>

#include <algorithm>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "common/build_info.h"
#include "common/cpu.h"
#include "common/evaluation/evaluation_starts.h"
#include "common/logging.h"
#include "common/status_macros.h"
#include "deploy/bundle/replaceable.h"
#include "deploy/bundle/run_export.h"
#include "learner/learner.h"
#include "learner/trainer/replay_need.h"
#include "proto/sinew/v1/rollout.pb.h"
#include "proto/sinew/v1/teacher.pb.h"
#include "tools/training/compact_state.h"
#include "tools/training/initial_policy.h"
#include "tools/training/kept_fallen_states.h"
#include "tools/training/make_learner.h"
#include "tools/training/run_sources.h"
#include "tools/training/run_teacher.h"
#include "tools/training/training_run.h"

namespace sinew::tools {
namespace {

InitialPolicy InitialOf(const TrainingRun::Options& options) {
  return {.init = options.init, .primitives = options.primitives};
}

// Of several teachers.
void LogLabels(const std::vector<v1::RunInputs::Source>& sources) {
  for (const v1::RunInputs::Source& source : sources) {
    if (source.labelled_clips().empty()) continue;
    LogInfo("a teacher labels clips of its own",
            {{"manifest_sha256", source.bundle().manifest_sha256()},
             {"recipe", source.bundle().recipe()},
             {"clips", source.labelled_clips_size()}});
  }
}

// Labels of another build may differ in bits.
void WarnOfOtherBuild(const v1::DescribeTeacherResponse& teacher) {
  if (teacher.build().empty() || teacher.build() == BuildIdentity()) return;
  LogWarning("the teacher is of another build: labels may differ in bits",
             {{"expected", BuildIdentity()}, {"found", teacher.build()}});
}

absl::Status CheckReplay(const v1::Recipe& recipe, const TaskSetup& setup,
                         int64_t limit_bytes) {
  SINEW_ASSIGN_OR_RETURN(const std::vector<v1::EvaluationStart> starts,
                         MakeEvaluationStarts(setup.library->manifest(),
                                              recipe.evaluation().starts(),
                                              recipe.evaluation().seconds()));
  return learner::CheckReplayHolds(
      recipe, setup.layout, static_cast<int64_t>(starts.size()), limit_bytes);
}

}  // namespace

TrainingRun::TrainingRun(const Options& options, Clock& clock,
                         const StopToken& stop)
    : options_(options),
      clock_(clock),
      stop_(stop),
      progress_({.is_terminal = isatty(STDERR_FILENO) == 1, .write = {}},
                clock) {}

TrainingRun::~TrainingRun() { SetProgramLogger(nullptr); }

absl::StatusOr<std::unique_ptr<TrainingRun>> TrainingRun::Open(
    const Options& options, Clock& clock, const StopToken& stop) {
  if (options.recipe.has_procedure()) {
    return absl::InvalidArgumentError(
        "recipe field procedure: expected a recipe of one training, found a "
        "procedure, which is not a run");
  }
  if (!options.continue_from.empty() &&
      !(options.init.empty() && options.primitives.empty())) {
    return absl::InvalidArgumentError(
        "--continue: expected neither --init nor --primitives beside it, since "
        "it has weights of its own, found one of them");
  }
  // The run's log is not open yet.
  std::vector<std::string> notes;
  SINEW_ASSIGN_OR_RETURN(
      const TaskSetup setup,
      SetUpTask(options.recipe, options.character, options.motions,
                [&](const std::map<std::string, std::string>& others) {
                  return FindFallenStatesAt(
                      {.address = options.checkpoint_address,
                       .folder = RunFolder::CheckpointsOf(options.directory),
                       .security = options.security},
                      clock, stop, others, &notes);
                }));
  if (options.replay_address.empty()) {
    SINEW_RETURN_IF_ERROR(CheckReplay(
        options.recipe, setup, options.recipe.rollouts().replay_bytes()));
  }
  SINEW_ASSIGN_OR_RETURN(
      std::optional<RunTeacher> teacher,
      OpenTeacher({.teachers = options.teachers,
                   .evaluations = options.teacher_evaluations,
                   .patience = options.teacher_patience,
                   .timeout = options.teacher_timeout,
                   .threads = options.ranks,
                   .security = options.security,
                   .stop = stop},
                  options.recipe, setup));
  std::unique_ptr<TrainingRun> run(new TrainingRun(options, clock, stop));
  run->teacher_ = std::move(teacher);
  run->run_id_ = learner::MakeRunId(options.recipe, setup.assets_sha256);
  SINEW_RETURN_IF_ERROR(run->OpenFolder());
  for (const std::string& note : notes) LogWarning(note);
  if (run->teacher_) WarnOfOtherBuild(run->teacher_->annotator->description());
  SINEW_RETURN_IF_ERROR(run->OpenStore(setup));
  SINEW_RETURN_IF_ERROR(run->StartServices(setup));
  SINEW_RETURN_IF_ERROR(run->MakeTrainer(setup));
  SINEW_RETURN_IF_ERROR(run->Resume());
  return run;
}

absl::Status TrainingRun::OpenFolder() {
  SINEW_ASSIGN_OR_RETURN(folder_,
                         RunFolder::Open(options_.directory, options_.recipe));
  // What could not be exported at the end is not trained for.
  SINEW_RETURN_IF_ERROR(bundle::CheckReplaceable(folder_->bundle()));
  SINEW_RETURN_IF_ERROR(bundle::CheckReplaceable(folder_->best_bundle()));
  return StartLogging();
}

absl::Status TrainingRun::OpenStore(const TaskSetup& setup) {
  const std::string where = options_.checkpoint_address.empty()
                                ? folder_->checkpoints()
                                : options_.checkpoint_address;
  SINEW_ASSIGN_OR_RETURN(store_,
                         RunStore::Open(where, options_.security, clock_));
  SINEW_RETURN_IF_ERROR(LoadState(where));
  // A compact state may go on with another recipe.
  const bool has_own_state = state_.has_value() && !moved_assets_;
  SINEW_RETURN_IF_ERROR(folder_->WriteConfig(
      options_.recipe, has_own_state ? state_->counters.recipe_sha256() : ""));
  SINEW_RETURN_IF_ERROR(CheckAssets(setup));
  std::optional<Resumption> resumption;
  if (state_) {
    resumption = {.moved = moved_sources_, .migrates = migrates_};
  }
  SINEW_ASSIGN_OR_RETURN(
      std::vector<v1::RunInputs::Source> sources,
      RunSources(folder_->path(), resumption, InitialOf(options_), teacher_));
  LogLabels(sources);
  if (state_) {
    AddEarlierTraining(state_->counters.curriculum(),
                       options_.recipe.task().start(),
                       setup.library->manifest(), &sources);
  }
  SINEW_RETURN_IF_ERROR(
      bundle::SaveRunInputs(folder_->path(), options_.character, *setup.library,
                            sources, setup.assets_sha256));
  SINEW_RETURN_IF_ERROR(store_->PutAssets(setup));
  best_ = std::make_unique<BestPolicy>(*store_, setup.assets_sha256);
  return best_->Load(state_ ? state_->counters.assets_sha256() : "");
}

absl::Status TrainingRun::LoadState(const std::string& where) {
  std::vector<std::string> warnings;
  auto state = store_->LoadState(&warnings);
  for (const std::string& warning : warnings) LogWarning(warning);
  if (absl::IsNotFound(state.status())) {
    SINEW_RETURN_IF_ERROR(CheckNothingIsLost(where));
    return LoadCompactState();
  }
  SINEW_RETURN_IF_ERROR(state.status());
  state_ = *std::move(state);
  return absl::OkStatus();
}

// A run's bundles are written at its end, after its state: where they are and
// no state is, it was lost, could not be saved or lies elsewhere, and a run
// that begins anew would replace them.
absl::Status TrainingRun::CheckNothingIsLost(const std::string& where) const {
  for (const std::string& bundle :
       {folder_->bundle(), folder_->best_bundle()}) {
    if (!FileExists(bundle)) continue;
    return absl::FailedPreconditionError(
        absl::StrCat(folder_->path(), ": expected the training state that ",
                     bundle, " is of, found none in ", where,
                     ": give where it is (--checkpoint), or another --run, or "
                     "remove the bundle"));
  }
  return absl::OkStatus();
}

absl::Status TrainingRun::LoadCompactState() {
  if (options_.continue_from.empty()) return absl::OkStatus();
  SINEW_ASSIGN_OR_RETURN(CompactState compact,
                         ReadCompactState(options_.continue_from, clock_));
  state_ = std::move(compact.state);
  moved_assets_ = std::move(compact.assets);
  moved_sources_ = std::move(compact.sources);
  migrates_ = true;
  return absl::OkStatus();
}

absl::Status TrainingRun::CheckAssets(const TaskSetup& setup) {
  if (!state_) return absl::OkStatus();
  const std::string& before = state_->counters.assets_sha256();
  if (before == setup.assets_sha256) return absl::OkStatus();
  SINEW_ASSIGN_OR_RETURN(const std::vector<std::string> changed,
                         moved_assets_ ? ChangedRoles(*moved_assets_, setup)
                                       : store_->ChangedAssets(before, setup));
  if (changed == std::vector<std::string>{"fallen"}) {
    return absl::FailedPreconditionError(absl::StrCat(
        folder_->path(),
        ": expected the fallen states that the run was started with, found "
        "others: its own cannot be read, and this build makes them otherwise; "
        "give another --run"));
  }
  const bool library_alone =
      !changed.empty() &&
      std::all_of(changed.begin(), changed.end(), [](const auto& role) {
        return role == "library" || role == "frames";
      });
  if (!library_alone) {
    return absl::FailedPreconditionError(absl::StrCat(
        folder_->path(),
        ": expected the character and the recipe that the run was started "
        "with, found others (changed: ",
        absl::StrJoin(changed, ", "), "); give the same, or another --run"));
  }
  if (!options_.migrate_library) {
    return absl::FailedPreconditionError(absl::StrCat(
        folder_->path(),
        ": expected the motion library that the run was started with, found "
        "another one in ",
        options_.motions,
        "; give the same, another --run, or --migrate-library to go on with "
        "this one (statistics of unchanged clips stay)"));
  }
  migrates_ = true;
  return absl::OkStatus();
}

absl::Status TrainingRun::StartLogging() {
  Logger::Options options;
  options.role = "learner";
  options.file = folder_->log();
  SINEW_ASSIGN_OR_RETURN(std::unique_ptr<Logger> logger,
                         Logger::Create(options, clock_));
  logger->SetConsole([this](absl::string_view line) { progress_.Line(line); });
  SetProgramLogger(std::move(logger));
  return absl::OkStatus();
}

absl::Status TrainingRun::StartServices(const TaskSetup& setup) {
  const v1::Rollouts& rollouts = options_.recipe.rollouts();
  RunServices::Options services;
  services.listen = options_.listen;
  services.security = options_.security;
  services.replay_address = options_.replay_address;
  services.replay_bytes = rollouts.replay_bytes();
  services.checkpoint_address = options_.checkpoint_address;
  services.assets = &store_->artifacts();
  services.metrics_address = options_.metrics_address;
  services.run_id = run_id_;
  services.assets_sha256 = setup.assets_sha256;
  services.reissue_after = absl::Seconds(rollouts.reissue_seconds());
  SINEW_ASSIGN_OR_RETURN(services_, RunServices::Start(services));
  if (!options_.replay_address.empty()) {
    // One that is away may come; what it then has no room for ends the run.
    const auto replay = services_->replay().GetStatus(stop_);
    if (replay.ok()) {
      SINEW_RETURN_IF_ERROR(
          CheckReplay(options_.recipe, setup, replay->limit_bytes()));
    }
  }
  saver_ = std::make_unique<learner::StateSaver>(
      store_->artifacts(), options_.recipe.checkpointing().keep(), clock_,
      services_->save_metrics());
  MakeExperience(setup);
  return absl::OkStatus();
}

void TrainingRun::MakeExperience(const TaskSetup& setup) {
  learner::ServiceExperience::Options experience;
  experience.run_id = run_id_;
  experience.layout = setup.layout;
  experience.limits = setup.limits;
  experience.address = address();
  // A transfer from elsewhere must fit into a step.
  if (!options_.replay_address.empty()) experience.step = absl::Seconds(30);
  experience.check = [this] {
    return children_.check ? children_.check() : absl::OkStatus();
  };
  experience.stop = stop_;
  experience_ = std::make_unique<learner::ServiceExperience>(
      std::move(experience), services_->server().dispatcher(),
      services_->replay(), services_->server().snapshots(), clock_);
}

absl::Status TrainingRun::MakeTrainer(const TaskSetup& setup) {
  std::optional<InitialPolicy> initial;
  if (!state_) {
    initial = InitialOf(options_);
    if (!options_.init_critic.empty()) {
      SINEW_ASSIGN_OR_RETURN(
          initial->critic, ReadCritic(options_.init_critic,
                                      options_.init_critic_iteration, clock_));
    }
  }
  SINEW_ASSIGN_OR_RETURN(
      auto learner,
      MakeLearner(options_.recipe, setup, options_.ranks, teacher_, initial));
  learner::Trainer::Options trainer;
  trainer.recipe = options_.recipe;
  trainer.library = setup.library->manifest();
  trainer.clip_sha256 = setup.clip_sha256;
  trainer.run_id = run_id_;
  trainer.assets_sha256 = setup.assets_sha256;
  trainer.layout_sha256 = setup.layout_sha256;
  SINEW_ASSIGN_OR_RETURN(
      trainer_, learner::Trainer::Create(std::move(trainer), std::move(learner),
                                         *experience_));
  return absl::OkStatus();
}

absl::Status TrainingRun::Resume() {
  if (state_) SINEW_RETURN_IF_ERROR(Restore());
  state_.reset();
  first_samples_ = trainer_->samples();
  first_train_seconds_ = figures_.seconds.train;
  SINEW_ASSIGN_OR_RETURN(metrics_log_, MetricsLog::Open(folder_->metrics(),
                                                        trainer_->iteration()));
  return absl::OkStatus();
}

absl::Status TrainingRun::Restore() {
  const v1::TrainingState& counters = state_->counters;
  figures_.seconds = {counters.wall_seconds(), counters.train_seconds()};
  if (counters.build() != BuildIdentity()) {
    LogWarning("the state is of another build: results may differ in bits",
               {{"expected", BuildIdentity()}, {"found", counters.build()}});
  }
  if (!counters.cpu_class().empty() && counters.cpu_class() != CpuClass()) {
    LogWarning("the state is of another processor: results may differ in bits",
               {{"expected", CpuClass()}, {"found", counters.cpu_class()}});
  }
  if (migrates_) return Migrate();
  SINEW_RETURN_IF_ERROR(trainer_->Restore(*state_));
  saved_iteration_ = trainer_->iteration();
  if (counters.has_metrics()) metrics_ = counters.metrics();
  for (size_t i = 0; i < state_->snapshots.size(); ++i) {
    best_->Remember(counters.snapshots(static_cast<int>(i)).version(),
                    std::make_shared<const std::string>(state_->snapshots[i]),
                    trainer_->samples(), figures_.seconds.train);
  }
  LogInfo("resumed", {{"iteration", trainer_->iteration()}});
  return absl::OkStatus();
}

// Nothing of before is remembered as the best: what was found of another
// library's clips is nothing to compare with.
absl::Status TrainingRun::Migrate() {
  SINEW_ASSIGN_OR_RETURN(const int unchanged, trainer_->Migrate(*state_));
  // Not saved yet: the newest state is that of the old library, or none.
  save_is_due_ = true;
  LogInfo(moved_assets_ ? "gone on from a compact state"
                        : "gone on with another library",
          {{"clips", trainer_->curriculum().table().clips_size()},
           {"unchanged", unchanged},
           {"iteration", trainer_->iteration()}});
  return absl::OkStatus();
}

}  // namespace sinew::tools
