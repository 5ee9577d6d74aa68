#ifndef SINEW_TOOLS_TRAINING_TRAINING_RUN_H_
#define SINEW_TOOLS_TRAINING_TRAINING_RUN_H_

#include <chrono>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/time/time.h"
#include "common/clock.h"
#include "common/rpc/credentials.h"
#include "common/stop.h"
#include "learner/experience/service_experience.h"
#include "learner/state/state_saver.h"
#include "learner/trainer/trainer.h"
#include "proto/sinew/v1/bundle.pb.h"
#include "proto/sinew/v1/recipe.pb.h"
#include "proto/sinew/v1/run.pb.h"
#include "tools/training/best_policy.h"
#include "tools/training/metrics_log.h"
#include "tools/training/progress.h"
#include "tools/training/run_folder.h"
#include "tools/training/run_services.h"
#include "tools/training/run_store.h"
#include "tools/training/run_teacher.h"
#include "tools/training/task_setup.h"

namespace sinew::tools {

// One run of training as `sinew train` and `sinew learner` do it: the task, the
// run directory, the servers, the trainer.
//
//   Open: recipe, character and library -> assets -> store
//         servers -> experience -> trainer <- latest state, if there is one
//   (actors come to address())
//   Train: iteration, row of metrics.jsonl, progress, best policy, save by
//          interval (beside training) until minutes or iterations are over,
//          the recipe's plateau is reached, or stop; then saves and exports
//          bundle/ and bundle_best/
//   Drain: actors go
//
// A run whose library has changed is refused before anything of it is touched,
// or goes on with the new one (migrate_library): Trainer::Migrate. So does one
// that begins from a compact state.
//
// A teacher that fails to label ends the run, with the peers named, after what
// there is is saved: nothing is guessed.
//
// A save that fails costs the chance to resume there and nothing else: it is
// counted and shown, and tried again at the next interval.
//
// Thread-safety: one caller. Ownership: owns all of it; borrows the clock.
// Blocking: Open for seconds (compiles, reads); Train until the run's end.
// Errors: Open: INVALID_ARGUMENT, NOT_FOUND for configuration,
// FAILED_PRECONDITION for a locked or foreign run directory, ALREADY_EXISTS for
// an address in use. Train: what the experience or the learner failed with,
// after saving what there is.
class TrainingRun {
 public:
  struct Options {
    v1::Recipe recipe;  // defaults filled, valid
    std::string character = "humanoid";
    std::string motions;
    std::string directory;
    // Ends, of the run in all; 0: the recipe's.
    double minutes = 0;
    int64_t iterations = 0;
    // Threads that learn, and cores that actors and learner share.
    int ranks = 1;
    int cores = 1;
    // Of RunServices.
    std::string listen;
    rpc::Security security = {};
    std::string replay_address = {};
    std::string metrics_address = {};
    // A checkpoint service; empty: the run directory.
    std::string checkpoint_address = {};
    // Bundle whose weights a run without states begins with; empty: none.
    std::string init = {};
    // Folder checkpoints/ of the run that `init` is of, whose newest value
    // network comes with it; empty: it starts untrained. DATA_LOSS unless that
    // state is of init_critic_iteration, as the bundle is.
    std::string init_critic = {};
    int64_t init_critic_iteration = 0;
    // Bundles that the recipe's composer weighs, if a run without states has
    // one.
    std::vector<std::string> primitives = {};
    // Compact state (compact_state.h) that a run without states goes on from
    // instead; empty: none.
    std::string continue_from = {};
    // Who labels, if the recipe has distillation: bundles, as folders or as
    // addresses of `sinew teacher` (run_teacher.h).
    std::vector<std::string> teachers = {};
    // Evaluations by which one of several teachers is chosen for a clip.
    std::vector<std::string> teacher_evaluations = {};
    // How long to go on asking teachers elsewhere without an answer, > 0.
    absl::Duration teacher_patience = absl::Minutes(2);
    // Of one call to them, > 0.
    absl::Duration teacher_timeout = absl::Seconds(30);
    // Go on with another library than the run's, if it is another.
    bool migrate_library = false;
  };
  // Child actors, if there are any.
  struct Children {
    std::function<absl::Status()> check;
    std::function<double()> cpu_seconds;
  };

  // How far it is.
  struct Result {
    int64_t iterations = 0;
    int64_t samples = 0;
    double train_seconds = 0;
    // The end that the recipe sets is reached (max_iterations or a plateau),
    // whatever Options::minutes and iterations say.
    bool finished = false;
    bool plateau = false;
    // PlateauState; 0 where the recipe has no plateau.
    double best_share = 0;
    int stalled = 0;
  };

  static absl::StatusOr<std::unique_ptr<TrainingRun>> Open(
      const Options& options, Clock& clock, const StopToken& stop);
  ~TrainingRun();

  // Where actors are to come.
  const std::string& address() const { return services_->server().address(); }
  const RunFolder& folder() const { return *folder_; }
  void SetChildren(Children children) { children_ = std::move(children); }

  absl::Status Train();
  Result result() const;
  void Drain(absl::Duration timeout) { services_->Drain(timeout); }
  // Instead: actors come back to the next run at this address.
  void Interrupt() { services_->Interrupt(); }
  // The one or the other: a run that is over has no more orders; one that was
  // stopped or has failed is to go on, and its actors wait for that.
  void Leave(absl::Duration timeout) {
    IsDone() ? Drain(timeout) : Interrupt();
  }

 private:
  TrainingRun(const Options& options, Clock& clock, const StopToken& stop);

  // training_run_open.cc.
  absl::Status OpenFolder();
  absl::Status OpenStore(const TaskSetup& setup);
  absl::Status LoadState(const std::string& where);
  // `where` states are, or would be.
  absl::Status CheckNothingIsLost(const std::string& where) const;
  absl::Status LoadCompactState();
  absl::Status StartLogging();
  absl::Status StartServices(const TaskSetup& setup);
  void MakeExperience(const TaskSetup& setup);
  absl::Status MakeTrainer(const TaskSetup& setup);
  absl::Status CheckAssets(const TaskSetup& setup);
  absl::Status Resume();
  absl::Status Restore();
  absl::Status Migrate();

  // training_run.cc.
  // Why the run is over; empty: it is not.
  std::string EndReason() const;
  bool IsDone() const { return !EndReason().empty(); }
  absl::Status RunIteration();
  void Account(const learner::IterationReport& report);
  void Tell(const learner::IterationReport& report);
  void Show(const learner::IterationReport& report);
  void SetEnd(ProgressState& state) const;
  learner::Trainer::State State() const;
  // Of saves that have ended.
  absl::Status TakeSaveResult();
  void SaveByInterval();
  absl::Status SaveAndWait();
  void KeepBest(const learner::IterationReport& report);
  absl::Status Export() const;

  const Options options_;
  Clock& clock_;
  const StopToken stop_;
  Children children_;
  Progress progress_;
  std::string run_id_;

  std::unique_ptr<RunFolder> folder_;
  std::unique_ptr<RunStore> store_;
  // Unset: PPO.
  std::optional<RunTeacher> teacher_;
  // The newest state, while the run is opened; unset: there is none.
  std::optional<learner::Trainer::State> state_;
  // Unset, or what `state_` was trained with: it is a compact one, of a run
  // that was elsewhere.
  std::optional<std::map<std::string, std::string>> moved_assets_;
  std::optional<std::vector<v1::RunInputs::Source>> moved_sources_;
  // The newest state is of another library, which the run is to leave, or is a
  // compact one.
  bool migrates_ = false;
  std::unique_ptr<RunServices> services_;
  std::unique_ptr<learner::StateSaver> saver_;
  std::unique_ptr<BestPolicy> best_;
  std::unique_ptr<learner::ServiceExperience> experience_;
  std::unique_ptr<learner::Trainer> trainer_;
  std::unique_ptr<MetricsLog> metrics_log_;

  RunFigures figures_;
  std::string evaluation_;  // latest, as text
  // Of the latest evaluation that has taken effect, in any session.
  std::optional<v1::BundleMetrics> metrics_;
  int64_t saved_iteration_ = -1;
  bool save_is_due_ = false;
  // Marks of the latest row.
  double row_seconds_ = 0;
  double row_learner_cpu_ = 0;
  double row_actors_cpu_ = 0;
  // When this process began.
  int64_t first_samples_ = 0;
  double first_train_seconds_ = 0;
};

}  // namespace sinew::tools

#endif  // SINEW_TOOLS_TRAINING_TRAINING_RUN_H_
