#ifndef SINEW_LEARNER_TRAINER_TRAINER_H_
#define SINEW_LEARNER_TRAINER_TRAINER_H_

#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "common/evaluation/evaluation_summary.h"
#include "learner/curriculum/curriculum.h"
#include "learner/curriculum/curriculum_summary.h"
#include "learner/learner.h"
#include "learner/trainer/annealer.h"
#include "learner/trainer/experience.h"
#include "learner/trainer/order_planner.h"
#include "learner/trainer/plateau.h"
#include "proto/sinew/v1/motion.pb.h"
#include "proto/sinew/v1/recipe.pb.h"
#include "proto/sinew/v1/training_state.pb.h"

namespace sinew::learner {

// What one iteration did, for metrics.jsonl, progress and reports.
struct IterationReport {
  int64_t iteration = 0;       // completed iterations
  int64_t samples = 0;         // in all
  int64_t policy_version = 0;  // newest snapshot
  UpdateStatistics update;
  // Episodes of the policy, not of teacher or prior, that ended in this
  // iteration, here and in what follows.
  int64_t episodes = 0;
  int64_t failed_episodes = 0;  // terminated; others were truncated:
  int64_t time_limit_episodes = 0, clip_end_episodes = 0;
  int64_t carried_episodes = 0;  // of all: begun where another left the body
  int64_t diverged = 0;          // simulations, whoever acted
  int64_t segments = 0;          // learned from, all of one lag:
  int64_t policy_lag = 0;        // versions that the orders were behind
  double mean_episode_steps = 0;
  int64_t physics_steps = 0;
  // Seconds of actor threads by stage, training orders only.
  v1::StageSeconds rollout_seconds;
  // Seconds of actor threads spent on evaluations that took effect now.
  double evaluation_core_seconds = 0;
  // Wall seconds of this iteration: waiting for segments, preparing (labels),
  // learning (the update alone), making and publishing the next snapshot.
  double wait_seconds = 0, label_seconds = 0, learn_seconds = 0,
         publish_seconds = 0;
  // An evaluation that took effect after this iteration.
  std::optional<EvaluationSummary> evaluation;
  int64_t evaluated_iteration = -1;  // iteration whose snapshot it tested
  // Of that evaluation: clips that starts are drawn from (Curriculum::Draws).
  SetSummary drawn;
  // After this iteration; unset: the recipe has no plateau.
  std::optional<v1::PlateauState> plateau;
  CurriculumSummary curriculum;  // of the newest snapshot
};

// The training loop without files, sockets or flags: plans orders, takes
// segments, learns, anneals, evaluates, under the lag contract:
//
//   iteration k, max_policy_lag L:
//     1. orders of k act with snapshot max(0, k - L)
//     2. take their segments, and those of the evaluations begun at
//        k + 1 - delay; absorb end states and episodes
//        (first the learner asks for labels, if it needs any: all may be done
//        again if that fails)
//     3. L = 1: begin the orders of k + 1 (with snapshot k)
//     4. update -> weights
//     5. the evaluations that were taken take effect, on the curriculum too,
//        on annealing (which samples may begin as well) and plateau by the
//        clips that starts are drawn from; start probabilities are made anew
//        -> snapshot k + 1
//     6. if due, an evaluation of snapshot k + 1 begins
//
// Deterministic: state and recipe give the same bits whatever runs the orders.
//
// Thread-safety: one caller. Ownership: owns learner and curriculum; borrows
// the experience. Blocking: RunIteration, for experience and learning. Errors:
// those of Experience::Take leave the state as it was (at_rest: save it, or
// call again), and so do those of Learner::Prepare, but the segments are gone
// (save it); others are fatal.
class Trainer {
 public:
  struct Options {
    v1::Recipe recipe;          // defaults filled
    v1::MotionLibrary library;  // manifest
    // Digests of its clips (sim/motion/clip_digest.h), or empty: no clip will
    // be recognised in another library then.
    std::vector<std::string> clip_sha256 = {};
    std::string run_id;
    std::string assets_sha256;
    std::string layout_sha256;
  };
  // INVALID_ARGUMENT: the recipe (ValidateRecipe), or it does not fit the
  // library.
  static absl::StatusOr<std::unique_ptr<Trainer>> Create(
      Options options, std::unique_ptr<Learner> learner,
      Experience& experience);

  absl::StatusOr<IterationReport> RunIteration();

  // Begins the orders of the next iteration, if they are not out already, so
  // that actors work while the caller saves or writes logs. RunIteration does
  // it otherwise; results are the same.
  absl::Status BeginNext();

  // Between two iterations, where Save makes sense; false for good after a
  // fatal failure.
  bool at_rest() const { return at_rest_; }
  int64_t iteration() const { return iteration_; }
  int64_t samples() const { return samples_; }
  const Learner& learner() const { return *learner_; }
  const Curriculum& curriculum() const { return *curriculum_; }
  // Evaluations have stopped improving, as the recipe's plateau defines it, and
  // what plateau.anneal began is through: the run is over. It stays so.
  bool plateau_ends_it() const;
  const v1::PlateauState& plateau() const { return plateau_.state(); }
  // Newest snapshot.
  const PublishedSnapshot& snapshot() const { return snapshots_.back(); }

  // The whole state between two iterations; `tensors`, `snapshots` and `chunks`
  // go beside it (snapshots that open orders need, oldest first; what the
  // learner keeps of earlier iterations, oldest first).
  struct State {
    v1::TrainingState counters;
    TensorMap tensors;
    std::vector<std::string> snapshots;  // bytes
    std::vector<StateChunk> chunks = {};
  };
  // A state's environments in the next episode of each that is within one,
  // without its body: so no random number is drawn twice.
  static std::vector<v1::EnvironmentState> NextEpisodes(
      const v1::TrainingState& counters);

  State Save() const;
  // Into a fresh trainer of the same options. FAILED_PRECONDITION or
  // INVALID_ARGUMENT naming what differs (recipe, assets, environments, a
  // snapshot's digest).
  absl::Status Restore(const State& state);
  // The same for the state of a run with the same recipe and character but
  // another library. Weights, optimisers and counters go on; so does what the
  // curriculum knows of unchanged clips, whose number is returned. Episodes
  // under way, orders and evaluations that are out belong to the old library:
  // environments begin new episodes, and unless annealing has started, it waits
  // anew for evaluations to stall; so does the plateau. That the character is
  // the same, the caller must know.
  absl::StatusOr<int> Migrate(const State& state);

 private:
  Trainer(Options options, std::unique_ptr<Learner> learner,
          Experience& experience, OrderPlanner planner);

  absl::Status PublishSnapshot();
  SnapshotName NewestSnapshot() const;
  absl::Status BeginTraining(int64_t iteration);
  struct Collected {
    std::vector<v1::Segment> training, evaluation;
  };
  // All that this iteration waits for, at once: nothing is taken on failure.
  absl::StatusOr<Collected> Collect();
  absl::Status Absorb(const std::vector<v1::Segment>& segments);
  // Whether an evaluation takes effect at the end of this iteration.
  bool IsDue(const v1::PendingEvaluation& pending) const;
  // What comes after an update: evaluations, next iteration's snapshot.
  absl::Status Conclude(const std::vector<v1::Segment>& evaluation,
                        IterationReport& report);
  void FinishEvaluations(const std::vector<v1::Segment>& segments,
                         IterationReport& report);
  // Summary of the clips that starts are drawn from.
  SetSummary SummariseDrawn(
      const std::vector<v1::EvaluationResult>& results) const;
  bool PolicyHadLearnt(int64_t iteration) const;
  void ObserveEvaluation(const SetSummary& drawn);
  absl::Status BeginEvaluationIfDue();
  absl::Status BeginAgain();
  // Learner, annealer, plateau and counters.
  absl::Status RestoreLearning(const State& state);

  const Options options_;
  std::unique_ptr<Learner> learner_;
  Experience& experience_;
  std::unique_ptr<Curriculum> curriculum_;
  OrderPlanner planner_;
  Annealer annealer_;
  Plateau plateau_;

  bool at_rest_ = true;
  int64_t iteration_ = 0;
  int64_t samples_ = 0;
  std::deque<PublishedSnapshot> snapshots_;  // newest last, at most 2
  std::vector<v1::Order> open_orders_;       // of iteration_, if begun
  std::deque<v1::PendingEvaluation> pending_;
};

// Name of a run's identity: SHA-256 over recipe and assets.
std::string MakeRunId(const v1::Recipe& recipe,
                      const std::string& assets_sha256);

}  // namespace sinew::learner

#endif  // SINEW_LEARNER_TRAINER_TRAINER_H_
