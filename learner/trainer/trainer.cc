#include "learner/trainer/trainer.h"

#include <algorithm>
#include <chrono>
#include <iterator>
#include <utility>

#include "absl/strings/str_cat.h"
#include "common/config/recipe.h"
#include "common/evaluation/evaluation_starts.h"
#include "common/segment/episode_actor.h"
#include "common/status_macros.h"
#include "learner/trainer/policy_snapshot.h"

namespace sinew::learner {
namespace {

// Snapshot k for the next iteration and k - 1 for open orders.
constexpr size_t kMaxSnapshots = 2;

double SecondsSince(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start)
      .count();
}

double CoreSeconds(const v1::StageSeconds& seconds) {
  return seconds.simulate() + seconds.infer() + seconds.observe() +
         seconds.encode();
}

// Whether an episode was the policy's own: those of others say nothing of it.
bool IsOfPolicy(const v1::Recipe& recipe, const v1::EpisodeEnd& episode) {
  return WhoActs(recipe.distillation(), recipe.seed(), episode.environment(),
                 episode.episode()) == EpisodeActor::kPolicy;
}

// Sums what the segments say into the report.
void SummariseSegments(const v1::Recipe& recipe,
                       const std::vector<v1::Segment>& segments,
                       IterationReport& report) {
  v1::StageSeconds& total = report.rollout_seconds;
  double steps = 0;
  report.segments = static_cast<int64_t>(segments.size());
  for (const v1::Segment& segment : segments) {
    report.diverged += segment.diverged();
    report.policy_lag = segment.iteration() - segment.snapshot_version();
    report.physics_steps += segment.physics_steps();
    const v1::StageSeconds& seconds = segment.seconds();
    total.set_simulate(total.simulate() + seconds.simulate());
    total.set_infer(total.infer() + seconds.infer());
    total.set_observe(total.observe() + seconds.observe());
    total.set_encode(total.encode() + seconds.encode());
    for (const v1::EpisodeEnd& episode : segment.episodes()) {
      if (!IsOfPolicy(recipe, episode)) continue;
      ++report.episodes;
      steps += episode.steps();
      report.failed_episodes +=
          episode.reason() == v1::EpisodeEnd::REASON_TERMINATED;
      report.time_limit_episodes +=
          episode.reason() == v1::EpisodeEnd::REASON_TIME_LIMIT;
      report.clip_end_episodes +=
          episode.reason() == v1::EpisodeEnd::REASON_CLIP_END;
      report.carried_episodes += episode.start_kind() == v1::START_KIND_CARRIED;
    }
  }
  if (report.episodes > 0) {
    report.mean_episode_steps = steps / static_cast<double>(report.episodes);
  }
}

std::vector<const v1::Segment*> PointersTo(
    const std::vector<v1::Segment>& segments) {
  std::vector<const v1::Segment*> pointers;
  for (const v1::Segment& segment : segments) pointers.push_back(&segment);
  return pointers;
}

}  // namespace

Trainer::Trainer(Options options, std::unique_ptr<Learner> learner,
                 Experience& experience, OrderPlanner planner)
    : options_(std::move(options)),
      learner_(std::move(learner)),
      experience_(experience),
      planner_(std::move(planner)),
      annealer_(options_.recipe.ppo().anneal()),
      plateau_(options_.recipe.plateau()) {}

absl::StatusOr<std::unique_ptr<Trainer>> Trainer::Create(
    Options options, std::unique_ptr<Learner> learner, Experience& experience) {
  const v1::Recipe& recipe = options.recipe;
  SINEW_RETURN_IF_ERROR(ValidateRecipe(recipe));
  SINEW_ASSIGN_OR_RETURN(
      std::unique_ptr<Curriculum> curriculum,
      Curriculum::Create(recipe.task().start(), options.library,
                         options.clip_sha256));
  OrderPlanner::Options plan;
  plan.run_id = options.run_id;
  plan.assets_sha256 = options.assets_sha256;
  plan.layout_sha256 = options.layout_sha256;
  plan.seed = recipe.seed();
  plan.rollouts = recipe.rollouts();
  SINEW_ASSIGN_OR_RETURN(
      plan.evaluation_starts,
      MakeEvaluationStarts(options.library, recipe.evaluation().starts(),
                           recipe.evaluation().seconds()));
  auto trainer = std::unique_ptr<Trainer>(
      new Trainer(std::move(options), std::move(learner), experience,
                  OrderPlanner(std::move(plan))));
  trainer->curriculum_ = std::move(curriculum);
  SINEW_RETURN_IF_ERROR(trainer->PublishSnapshot());
  return trainer;
}

absl::Status Trainer::PublishSnapshot() {
  snapshots_.push_back(MakePolicySnapshot(iteration_, learner_->graph(),
                                          learner_->weights(),
                                          curriculum_->table()));
  if (snapshots_.size() > kMaxSnapshots) snapshots_.pop_front();
  return experience_.Publish(snapshots_.back());
}

SnapshotName Trainer::NewestSnapshot() const {
  return {snapshots_.back().snapshot.version(), snapshots_.back().sha256};
}

absl::Status Trainer::BeginTraining(int64_t iteration) {
  open_orders_ = planner_.PlanTraining(iteration, NewestSnapshot());
  return experience_.Begin(open_orders_);
}

absl::Status Trainer::BeginNext() {
  return open_orders_.empty() ? BeginTraining(iteration_) : absl::OkStatus();
}

bool Trainer::IsDue(const v1::PendingEvaluation& pending) const {
  return pending.begun_iteration() + options_.recipe.evaluation().delay() <=
         iteration_ + 1;
}

absl::StatusOr<Trainer::Collected> Trainer::Collect() {
  std::vector<int64_t> ids;
  for (const v1::Order& order : open_orders_) ids.push_back(order.order_id());
  for (const v1::PendingEvaluation& pending : pending_) {
    if (!IsDue(pending)) break;
    for (const v1::Order& order : pending.orders()) {
      ids.push_back(order.order_id());
    }
  }
  Collected result;
  SINEW_ASSIGN_OR_RETURN(result.training, experience_.Take(ids));
  const auto evaluations = result.training.begin() + open_orders_.size();
  result.evaluation.assign(std::make_move_iterator(evaluations),
                           std::make_move_iterator(result.training.end()));
  result.training.erase(evaluations, result.training.end());
  return result;
}

absl::Status Trainer::Absorb(const std::vector<v1::Segment>& segments) {
  SINEW_RETURN_IF_ERROR(planner_.Absorb(open_orders_, segments));
  open_orders_.clear();
  for (const v1::Segment& segment : segments) {
    for (const v1::EpisodeEnd& episode : segment.episodes()) {
      if (!IsOfPolicy(options_.recipe, episode)) continue;
      curriculum_->Record(episode, iteration_);
    }
  }
  return absl::OkStatus();
}

absl::StatusOr<IterationReport> Trainer::RunIteration() {
  IterationReport report;
  const auto start = std::chrono::steady_clock::now();
  SINEW_RETURN_IF_ERROR(BeginNext());
  SINEW_ASSIGN_OR_RETURN(const Collected collected, Collect());
  report.wait_seconds = SecondsSince(start);
  const auto prepare_start = std::chrono::steady_clock::now();
  const auto pointers = PointersTo(collected.training);
  SINEW_RETURN_IF_ERROR(learner_->Prepare(pointers));
  report.label_seconds = SecondsSince(prepare_start);
  // From here on nothing waits for others; a failure is fatal.
  at_rest_ = false;
  SINEW_RETURN_IF_ERROR(Absorb(collected.training));
  SummariseSegments(options_.recipe, collected.training, report);
  if (options_.recipe.rollouts().max_policy_lag() > 0) {
    SINEW_RETURN_IF_ERROR(BeginTraining(iteration_ + 1));
  }

  const auto learn_start = std::chrono::steady_clock::now();
  SINEW_ASSIGN_OR_RETURN(report.update, learner_->Update(pointers, iteration_));
  report.learn_seconds = SecondsSince(learn_start);
  const auto publish_start = std::chrono::steady_clock::now();
  SINEW_RETURN_IF_ERROR(Conclude(collected.evaluation, report));
  report.publish_seconds = SecondsSince(publish_start);
  at_rest_ = true;
  report.iteration = iteration_;
  report.samples = samples_;
  report.policy_version = snapshots_.back().snapshot.version();
  report.curriculum = Summarise(curriculum_->table(), curriculum_->rule());
  return report;
}

absl::Status Trainer::Conclude(const std::vector<v1::Segment>& evaluation,
                               IterationReport& report) {
  FinishEvaluations(evaluation, report);
  curriculum_->Reweigh();
  ++iteration_;
  samples_ += report.update.samples;
  if (report.evaluation && PolicyHadLearnt(report.evaluated_iteration)) {
    ObserveEvaluation(report.drawn);
  }
  annealer_.Advance(samples_, iteration_);
  if (plateau_.enabled()) report.plateau = plateau_.state();
  learner_->SetFactors(annealer_.StdFactor(samples_),
                       annealer_.LearningRateFactor(samples_));
  SINEW_RETURN_IF_ERROR(PublishSnapshot());
  return BeginEvaluationIfDue();
}

void Trainer::FinishEvaluations(const std::vector<v1::Segment>& segments,
                                IterationReport& report) {
  size_t first = 0;
  while (!pending_.empty() && IsDue(pending_.front())) {
    const size_t end = first + pending_.front().orders_size();
    std::vector<v1::EvaluationResult> results;
    for (; first < end; ++first) {
      results.insert(results.end(), segments[first].results().begin(),
                     segments[first].results().end());
      report.evaluation_core_seconds += CoreSeconds(segments[first].seconds());
    }
    report.evaluation =
        SummariseEvaluation(results, LeftOutClips(options_.library));
    report.drawn = SummariseDrawn(results);
    report.evaluated_iteration = pending_.front().begun_iteration();
    curriculum_->RecordEvaluation(results, report.evaluated_iteration);
    pending_.pop_front();
  }
}

SetSummary Trainer::SummariseDrawn(
    const std::vector<v1::EvaluationResult>& results) const {
  std::vector<bool> others;
  for (int clip = 0; clip < options_.library.clips_size(); ++clip) {
    others.push_back(!curriculum_->Draws(clip));
  }
  return SummariseEvaluation(results, others).training;
}

// A policy that stands still is no sign of a plateau: the snapshot that an
// iteration begins with is as many updates old, and those of the warm-up leave
// the policy alone.
bool Trainer::PolicyHadLearnt(int64_t iteration) const {
  return iteration > options_.recipe.ppo().value_warmup_iterations();
}

// What starts are not drawn from decides nothing.
void Trainer::ObserveEvaluation(const SetSummary& drawn) {
  const double share =
      static_cast<double>(drawn.succeeded_starts) / std::max(1, drawn.starts);
  annealer_.Observe(share, drawn.survived_share, samples_);
  plateau_.Observe(share, samples_);
  if (plateau_.reached() && options_.recipe.plateau().anneal()) {
    annealer_.Start(samples_);
  }
}

bool Trainer::plateau_ends_it() const {
  return plateau_.reached() &&
         (!options_.recipe.plateau().anneal() || annealer_.Finished(samples_));
}

absl::Status Trainer::BeginEvaluationIfDue() {
  const int interval = options_.recipe.evaluation().interval();
  if (interval == 0 || iteration_ % interval != 0) return absl::OkStatus();
  const std::vector<v1::Order> orders =
      planner_.PlanEvaluation(iteration_, NewestSnapshot());
  v1::PendingEvaluation& pending = pending_.emplace_back();
  pending.set_begun_iteration(iteration_);
  pending.mutable_orders()->Assign(orders.begin(), orders.end());
  return experience_.Begin(orders);
}

}  // namespace sinew::learner
