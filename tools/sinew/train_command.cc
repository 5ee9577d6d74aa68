#include "tools/sinew/train_command.h"

#include <unistd.h>

#include <chrono>
#include <cstdint>
#include <cstdio>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "actor/rollout_assets.h"
#include "common/clock.h"
#include "common/config/recipe.h"
#include "common/digest.h"
#include "common/files.h"
#include "common/status_macros.h"
#include "deploy/checkpoint/local_store.h"
#include "learner/ppo/ppo_learner.h"
#include "learner/state/state_store.h"
#include "learner/trainer/trainer.h"
#include "sim/character/character.h"
#include "sim/motion/library.h"
#include "sim/world/mirror.h"
#include "tools/local/local_experience.h"
#include "tools/sinew/metrics_log.h"
#include "tools/sinew/resources.h"

namespace sinew::tools {
namespace {

struct TrainOptions {
  std::string recipe;     // name or file
  std::string motions;    // library folder
  std::string run;        // run folder; resumed if it holds a state
  std::string character = "humanoid";
  double minutes = 0;     // of train_s in all; 0: the recipe's
  int64_t iterations = 0; // in all; 0: the recipe's
  std::optional<uint64_t> seed;
  int threads = 0;        // for rollouts and learning; 0: all cores
  std::vector<std::string> set;
};

double NowSeconds() {
  return std::chrono::duration<double>(
             std::chrono::steady_clock::now().time_since_epoch())
      .count();
}

absl::StatusOr<v1::Recipe> RecipeOf(const TrainOptions& options) {
  std::vector<std::string> set = options.set;
  if (options.seed) set.push_back(absl::StrCat("seed=", *options.seed));
  return LoadRecipe(options.recipe, set);
}

// One run of the command: what the loop needs.
class Session {
 public:
  static absl::StatusOr<std::unique_ptr<Session>> Open(
      const TrainOptions& options);

  absl::Status Loop(const StopToken& stop);

 private:
  Session() = default;
  absl::Status Resume();
  absl::Status Save();
  bool IsDone() const;
  void Account(const learner::IterationReport& report, double elapsed);
  void ShowProgress(const learner::IterationReport& report) const;

  v1::Recipe recipe_;
  std::string run_;
  int threads_ = 1;
  double max_minutes_ = 0;
  int64_t max_iterations_ = 0;
  std::unique_ptr<DirectoryLock> lock_;
  std::unique_ptr<LocalExperience> experience_;
  std::unique_ptr<learner::Trainer> trainer_;
  const SystemClock clock_;
  std::unique_ptr<checkpoint::LocalStore> store_;
  std::unique_ptr<MetricsLog> metrics_;
  RunSeconds seconds_;
  int64_t saved_iteration_ = -1;
};

absl::StatusOr<std::unique_ptr<Session>> Session::Open(
    const TrainOptions& options) {
  auto session = std::unique_ptr<Session>(new Session());
  SINEW_ASSIGN_OR_RETURN(session->recipe_, RecipeOf(options));
  const v1::Recipe& recipe = session->recipe_;
  session->run_ = options.run;
  session->max_minutes_ =
      options.minutes > 0 ? options.minutes : recipe.max_minutes();
  session->max_iterations_ =
      options.iterations > 0 ? options.iterations : recipe.max_iterations();
  session->threads_ =
      options.threads > 0
          ? options.threads
          : static_cast<int>(std::thread::hardware_concurrency());

  SINEW_ASSIGN_OR_RETURN(
      auto character,
      character::Character::Load(options.character, recipe.physics()));
  SINEW_ASSIGN_OR_RETURN(auto library, motion::Library::Load(options.motions));
  const v1::MotionLibrary manifest = library->manifest();
  const std::string assets_sha256 = Sha256Hex(absl::StrCat(
      character->digest(), library->digest(), PrintRecipe(recipe)));
  SINEW_ASSIGN_OR_RETURN(
      const std::shared_ptr<const actor::RolloutAssets> assets,
      actor::RolloutAssets::FromParts(recipe, std::move(character),
                                      std::move(library)));

  SINEW_RETURN_IF_ERROR(MakeDirectories(session->run_));
  SINEW_ASSIGN_OR_RETURN(session->lock_, DirectoryLock::Acquire(session->run_));
  SINEW_RETURN_IF_ERROR(
      WriteFileAtomically(JoinPath(session->run_, "config.textproto"),
                          PrintRecipe(recipe)));
  LocalExperience::Options local;
  local.threads = session->threads_;
  local.max_environments = recipe.rollouts().environments_per_order();
  SINEW_ASSIGN_OR_RETURN(session->experience_,
                         LocalExperience::Create(local, assets));
  std::optional<SegmentMirror> mirror;
  if (recipe.ppo().mirror()) {
    SINEW_ASSIGN_OR_RETURN(mirror, world::MakeMirror(assets->task()));
  }
  SINEW_ASSIGN_OR_RETURN(
      auto learner,
      learner::PpoLearner::Create(
          recipe, {.observation_width = assets->task().observation_width(),
                   .action_width = assets->task().action_width(),
                   .ranks = session->threads_,
                   .mirror = mirror}));
  learner::Trainer::Options trainer;
  trainer.recipe = recipe;
  trainer.library = manifest;
  trainer.run_id = learner::MakeRunId(recipe, assets_sha256);
  trainer.assets_sha256 = assets_sha256;
  trainer.layout_sha256 = assets->layout_sha256();
  SINEW_ASSIGN_OR_RETURN(
      session->trainer_,
      learner::Trainer::Create(std::move(trainer), std::move(learner),
                               *session->experience_));
  SINEW_RETURN_IF_ERROR(session->Resume());
  return session;
}

absl::Status Session::Resume() {
  std::vector<std::string> warnings;
  SINEW_ASSIGN_OR_RETURN(
      store_,
      checkpoint::LocalStore::Open(JoinPath(run_, "checkpoints"), clock_));
  auto state = learner::LoadLatestState(*store_, &warnings);
  for (const std::string& warning : warnings) {
    absl::FPrintF(stderr, "sinew: %s\n", warning);
  }
  if (state.ok()) {
    SINEW_RETURN_IF_ERROR(trainer_->Restore(*state));
    seconds_ = {state->counters.wall_seconds(), state->counters.train_seconds()};
    saved_iteration_ = trainer_->iteration();
    absl::FPrintF(stderr, "sinew: resumed at iteration %d\n",
                  trainer_->iteration());
  } else if (!absl::IsNotFound(state.status())) {
    return state.status();
  }
  SINEW_ASSIGN_OR_RETURN(metrics_,
                         MetricsLog::Open(JoinPath(run_, "metrics.jsonl"),
                                          trainer_->iteration()));
  return absl::OkStatus();
}

absl::Status Session::Save() {
  if (saved_iteration_ == trainer_->iteration()) return absl::OkStatus();
  learner::Trainer::State state = trainer_->Save();
  state.counters.set_wall_seconds(seconds_.wall);
  state.counters.set_train_seconds(seconds_.train);
  SINEW_RETURN_IF_ERROR(learner::SaveState(*store_, state,
                                           recipe_.checkpointing().keep()));
  saved_iteration_ = trainer_->iteration();
  return absl::OkStatus();
}

bool Session::IsDone() const {
  return (max_iterations_ > 0 && trainer_->iteration() >= max_iterations_) ||
         (max_minutes_ > 0 && seconds_.train >= 60 * max_minutes_);
}

void Session::Account(const learner::IterationReport& report, double elapsed) {
  seconds_.wall += elapsed;
  seconds_.train += elapsed - report.evaluation_core_seconds / threads_;
}

void Session::ShowProgress(const learner::IterationReport& report) const {
  if (report.evaluation) {
    const SetSummary& overall = report.evaluation->overall;
    absl::FPrintF(stderr,
                  "\r\033[Kiteration %d  train %.0f s  samples %d  %d of %d "
                  "starts  survived %.0f %%  %.0f mm\n",
                  report.iteration, seconds_.train, report.samples,
                  overall.succeeded_starts, overall.starts,
                  100 * overall.survived_share, overall.means.e_g_mpjpe_mm);
  }
  if (isatty(STDERR_FILENO) == 0) return;
  absl::FPrintF(stderr, "\r\033[K%d  %.1f k samples/s  reward %.3f  %.1f min",
                report.iteration,
                static_cast<double>(report.samples) / seconds_.train / 1000,
                report.update.reward_mean, seconds_.train / 60);
}

absl::Status Session::Loop(const StopToken& stop) {
  while (!IsDone() && !stop.stop_requested()) {
    const double start = NowSeconds();
    SINEW_ASSIGN_OR_RETURN(const learner::IterationReport report,
                           trainer_->RunIteration());
    Account(report, NowSeconds() - start);
    const absl::Status logged = metrics_->Write(report, seconds_);
    if (!logged.ok()) absl::FPrintF(stderr, "sinew: %s\n", logged.ToString());
    ShowProgress(report);
    if (trainer_->iteration() % recipe_.checkpointing().interval() == 0) {
      // A failed save costs nothing but the chance to resume here.
      const absl::Status saved = Save();
      if (!saved.ok()) absl::FPrintF(stderr, "sinew: %s\n", saved.ToString());
    }
  }
  absl::FPrintF(stderr, "\n");
  return Save();
}

absl::Status RunTrain(const TrainOptions& options, const StopToken& stop) {
  SINEW_ASSIGN_OR_RETURN(const std::unique_ptr<Session> session,
                         Session::Open(options));
  return session->Loop(stop);
}

}  // namespace

void AddTrainCommand(CLI::App& app, Action& action) {
  auto options = std::make_shared<TrainOptions>();
  auto* command = AddSubcommand<TrainOptions>(
      app, "train", "start or resume a run", options, action, RunTrain);
  command->add_option("--recipe", options->recipe, "name or file")->required();
  command->add_option("--motions", options->motions, "library")->required();
  command->add_option("--run", options->run, "run directory")->required();
  command->add_option("--character", options->character, "name or file");
  command->add_option("--minutes", options->minutes, "of training, in all");
  command->add_option("--iterations", options->iterations, "in all");
  command->add_option("--seed", options->seed, "of all random streams");
  command->add_option("--threads", options->threads, "default: all cores");
  command->add_option("--set", options->set, "path=value in the recipe");
}

}  // namespace sinew::tools
