#include "learner/ppo/ppo_learner.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "absl/strings/str_cat.h"
#include "common/check.h"
#include "common/config/recipe.h"
#include "common/segment/segment_layout.h"
#include "common/status_macros.h"
#include "learner/ppo/batch.h"
#include "learner/ppo/initial_policy.h"
#include "learner/ppo/ppo_networks.h"
#include "learner/ppo/ppo_update.h"
#include "learner/torch/runtime.h"
#include "learner/update/graph_normalisers.h"
#include "learner/update/normaliser.h"
#include "learner/update/rank_pool.h"
#include "learner/update/running_state.h"

namespace sinew::learner {
namespace {

// Name of a parameter (common/policy/builder.h, latent_builder.h).
constexpr char kStd[] = "policy/std";

// Rows of one task of the value pass.
constexpr int64_t kValueRows = 2048;

// The adaptive learning rate: step, and range relative to the recipe's.
constexpr double kRateStep = 1.5;
constexpr double kLeastRate = 0.1;
constexpr double kLargestRate = 4.0;

class Ppo final : public PpoLearner {
 public:
  Ppo(const v1::Recipe& recipe, const Options& options, v1::PolicyGraph graph,
      std::unique_ptr<PpoNetworks> networks)
      : recipe_(recipe),
        graph_(std::move(graph)),
        networks_(std::move(networks)),
        has_primitives_(!recipe.network().has_composer()),
        pool_(options.ranks, UseOneThread),
        mirror_(recipe.ppo().mirror() ? options.mirror : std::nullopt),
        batch_(options.action_width,
               MakeSegmentLayout(
                   options.observation_width, options.action_width,
                   /*distillation=*/false, RecordedLatentWidth(recipe)),
               recipe.ppo().discount(), recipe.ppo().gae_lambda()),
        running_({.moments = Moments(options.observation_width)}) {}

  absl::StatusOr<UpdateStatistics> Update(
      absl::Span<const v1::Segment* const> segments,
      int64_t iteration) override {
    SINEW_RETURN_IF_ERROR(CheckPrimitives());
    SINEW_ASSIGN_OR_RETURN(const std::vector<const v1::Segment*> all,
                           WithMirrorImages(segments));
    SINEW_RETURN_IF_ERROR(batch_.Reset(
        all, /*images=*/static_cast<int64_t>(all.size() - segments.size())));
    SINEW_RETURN_IF_ERROR(CheckSize());
    SINEW_RETURN_IF_ERROR(LoadSegments());
    SINEW_RETURN_IF_ERROR(ComputeValues());
    pool_.Run(batch_.num_segments(),
              [&](int segment) { batch_.ComputeReturns(segment); });
    const BatchFigures batch = batch_.Finish();
    SINEW_RETURN_IF_ERROR(networks_->SetTargets(batch_));
    UpdateStatistics statistics = Describe(batch);
    if (mirror_) statistics.samples /= 2;
    SINEW_ASSIGN_OR_RETURN(
        const UpdateFigures figures,
        RunEpochs(Settings(iteration), batch_, *networks_, pool_));
    Add(figures, statistics);
    if (!PolicyLearns(iteration)) {
      statistics.policy_learning_rate = 0;
      statistics.latent_kl.reset();
      return statistics;
    }
    for (const Moments& moments : segment_moments_) {
      MergeMoments(moments, running_.moments);
    }
    AdaptRate(figures.kl);
    SINEW_RETURN_IF_ERROR(ApplyNormaliser());
    return statistics;
  }

  const v1::PolicyGraph& graph() const override { return graph_; }
  TensorMap weights() const override { return networks_->SaveWeights(); }

  TensorMap SaveTensors() const override {
    TensorMap tensors = networks_->SaveWeights();
    networks_->SaveOptimiser(NetworkId::kPolicy, tensors);
    networks_->SaveOptimiser(NetworkId::kValue, tensors);
    SaveRunningState(running_, tensors);
    return tensors;
  }

  void SaveCounters(v1::TrainingState& state) const override {
    state.set_policy_optimiser_step(
        networks_->optimiser_steps(NetworkId::kPolicy));
    state.set_value_optimiser_step(
        networks_->optimiser_steps(NetworkId::kValue));
    state.set_learning_rate_factor(adaptive_factor_);
    state.set_normaliser_count(running_.moments.count);
  }

  absl::Status Load(const TensorMap& tensors, const v1::TrainingState& state,
                    absl::Span<const StateChunk> chunks) override;
  absl::Status InitFrom(const TensorMap& weights) override;
  absl::Status InitFromPrimitives(
      absl::Span<const Primitive> primitives) override;

  void SetFactors(double std_factor, double learning_rate_factor) override {
    running_.learning_rate_factor = learning_rate_factor;
    if (std_factor == running_.std_factor) return;
    running_.std_factor = std_factor;
    TensorMap weights = networks_->SaveWeights();
    for (float& std : weights.at(kStd).mutable_float32()) {
      std = static_cast<float>(recipe_.network().initial_std() * std_factor);
    }
    const absl::Status loaded = networks_->LoadWeights(weights);
    SINEW_CHECK(loaded.ok()) << loaded.ToString();
  }

 private:
  absl::Status BeginWith(const TensorMap& weights);
  absl::Status LoadNetworks(const TensorMap& tensors,
                            const v1::TrainingState& state);

  // The segments, then their mirror images if the recipe asks for them.
  absl::StatusOr<std::vector<const v1::Segment*>> WithMirrorImages(
      absl::Span<const v1::Segment* const> segments) {
    std::vector<const v1::Segment*> all(segments.begin(), segments.end());
    if (!mirror_) return all;
    images_.resize(segments.size());
    SINEW_RETURN_IF_ERROR(pool_.TryRun(
        static_cast<int>(segments.size()), [&](int i) -> absl::Status {
          SINEW_ASSIGN_OR_RETURN(images_[i],
                                 MirrorSegment(*segments[i], *mirror_));
          return absl::OkStatus();
        }));
    for (const v1::Segment& image : images_) all.push_back(&image);
    return all;
  }

  absl::Status CheckPrimitives() const {
    if (has_primitives_) return absl::OkStatus();
    return absl::FailedPreconditionError(
        absl::StrCat("recipe field network.composer: expected the weights of ",
                     recipe_.network().composer().primitives(),
                     " primitives before the first update, found none"));
  }

  absl::Status CheckSize() const {
    const int64_t rows = batch_.rows();
    const int64_t minibatch = recipe_.ppo().minibatch();
    if (rows > 0 && rows % minibatch == 0) return absl::OkStatus();
    return absl::InvalidArgumentError(absl::StrCat(
        "segments: expected a multiple of ppo.minibatch = ", minibatch,
        " rows, found ", rows, " in ", batch_.num_segments(), " segments"));
  }

  // Columns, observations at the networks' frontier, moments.
  absl::Status LoadSegments() {
    SINEW_RETURN_IF_ERROR(
        networks_->Reserve(batch_.rows() + batch_.bootstrap_rows()));
    segment_moments_.resize(
        batch_.num_segments(),
        Moments(static_cast<int64_t>(running_.moments.mean.size())));
    return pool_.TryRun(
        batch_.num_segments(), [&](int segment) -> absl::Status {
          batch_.CopyColumns(segment);
          for (const Batch::Block& block : batch_.Blocks(segment)) {
            SINEW_RETURN_IF_ERROR(networks_->LoadObservations(
                block.first_row, block.observations, block.latent_noise));
          }
          const SegmentView& view = batch_.view(segment);
          ComputeMoments(view.observation, view.valid,
                         segment_moments_[segment]);
          return absl::OkStatus();
        });
  }

  absl::Status ComputeValues() {
    const absl::Span<float> values = batch_.values();
    const int64_t rows = static_cast<int64_t>(values.size());
    const int tasks = static_cast<int>((rows + kValueRows - 1) / kValueRows);
    return pool_.TryRun(tasks, [&](int task) {
      // Equal parts, so that the last task is not a small one.
      const int64_t begin = rows * task / tasks;
      const int64_t end = rows * (task + 1) / tasks;
      return networks_->Values(begin, values.subspan(begin, end - begin));
    });
  }

  UpdateSettings Settings(int64_t iteration) const {
    const v1::Ppo& ppo = recipe_.ppo();
    return {.seed = recipe_.seed(),
            .iteration = iteration,
            .epochs = ppo.epochs(),
            .minibatch = ppo.minibatch(),
            .shards = ppo.shards(),
            .kl_stop = ppo.kl_stop(),
            .max_gradient_norm = ppo.max_gradient_norm(),
            .learning_rate = {PolicyRate(), ValueRate()},
            .policy_learns = PolicyLearns(iteration)};
  }

  // Else nothing that the policy is made of changes: the normaliser neither.
  bool PolicyLearns(int64_t iteration) const {
    return iteration >= recipe_.ppo().value_warmup_iterations();
  }

  double PolicyRate() const {
    return recipe_.ppo().policy_learning_rate() * adaptive_factor_ *
           running_.learning_rate_factor;
  }
  double ValueRate() const {
    return recipe_.ppo().value_learning_rate() * running_.learning_rate_factor;
  }

  UpdateStatistics Describe(const BatchFigures& batch) const {
    UpdateStatistics statistics;
    statistics.samples = batch.valid_rows;
    statistics.explained_variance = batch.explained_variance;
    statistics.reward_mean = batch.reward_mean;
    statistics.reward_terms = batch.reward_terms;
    statistics.body_distance_mean_m = batch.body_distance_mean_m;
    statistics.policy_learning_rate = PolicyRate();
    statistics.value_learning_rate = ValueRate();
    statistics.std_factor = running_.std_factor;
    const NetworkFlops policy = networks_->flops(NetworkId::kPolicy);
    const NetworkFlops value = networks_->flops(NetworkId::kValue);
    statistics.flops =
        static_cast<double>(batch_.rows() + batch_.bootstrap_rows()) *
        (policy.load + value.load + value.forward);
    return statistics;
  }

  void Add(const UpdateFigures& figures, UpdateStatistics& statistics) const {
    statistics.epochs = figures.epochs;
    statistics.policy_loss = figures.policy_loss;
    statistics.value_loss = figures.value_loss;
    statistics.entropy = figures.entropy;
    statistics.kl = figures.kl;
    statistics.clip_fraction = figures.clip_fraction;
    statistics.policy_gradient_norm = figures.gradient_norm[0];
    statistics.value_gradient_norm = figures.gradient_norm[1];
    statistics.non_finite = figures.non_finite;
    statistics.flops += figures.flops;
    if (recipe_.network().has_latent())
      statistics.latent_kl = figures.latent_kl;
  }

  void AdaptRate(double kl) {
    const double target = recipe_.ppo().kl_target();
    if (target <= 0) return;
    if (kl > 2 * target) adaptive_factor_ /= kRateStep;
    if (kl < target / 2) adaptive_factor_ *= kRateStep;
    adaptive_factor_ = std::clamp(adaptive_factor_, kLeastRate, kLargestRate);
  }

  absl::Status ApplyNormaliser() {
    TensorMap weights = networks_->SaveWeights();
    WriteNormalisers(running_.moments, weights);
    return networks_->LoadWeights(weights);
  }

  const v1::Recipe recipe_;  // defaults filled
  const v1::PolicyGraph graph_;
  const std::unique_ptr<PpoNetworks> networks_;
  bool has_primitives_;  // or needs none
  RankPool pool_;
  const std::optional<SegmentMirror> mirror_;
  std::vector<v1::Segment> images_;  // of this update
  Batch batch_;
  RunningState running_;
  std::vector<Moments> segment_moments_;  // of this update
  double adaptive_factor_ = 1;            // by KL
};

absl::Status Ppo::Load(const TensorMap& tensors, const v1::TrainingState& state,
                       absl::Span<const StateChunk> chunks) {
  constexpr char kSource[] = "training state";
  SINEW_RETURN_IF_ERROR(CheckFinite(tensors, kSource));
  if (!chunks.empty()) {
    return absl::InvalidArgumentError(
        absl::StrCat(kSource, ": expected no memory with PPO, found ",
                     chunks.size(), " chunks"));
  }
  const int64_t width = static_cast<int64_t>(running_.moments.mean.size());
  SINEW_ASSIGN_OR_RETURN(
      RunningState running,
      LoadRunningState(tensors, width, state.normaliser_count()));
  if (state.policy_optimiser_step() < 0 || state.value_optimiser_step() < 0 ||
      !(state.normaliser_count() >= 0) || !(state.learning_rate_factor() > 0)) {
    return absl::InvalidArgumentError(absl::StrCat(
        kSource,
        ": expected optimiser steps and normaliser_count >= 0 and "
        "learning_rate_factor > 0, found ",
        state.policy_optimiser_step(), ", ", state.value_optimiser_step(), ", ",
        state.normaliser_count(), " and ", state.learning_rate_factor()));
  }
  const TensorMap before = SaveTensors();
  v1::TrainingState state_before;
  SaveCounters(state_before);
  if (const absl::Status loaded = LoadNetworks(tensors, state); !loaded.ok()) {
    const absl::Status back = LoadNetworks(before, state_before);
    SINEW_CHECK(back.ok()) << back.ToString();
    return loaded;
  }
  running_ = std::move(running);
  adaptive_factor_ = state.learning_rate_factor();
  has_primitives_ = true;
  return absl::OkStatus();
}

// May load a part if it fails.
absl::Status Ppo::LoadNetworks(const TensorMap& tensors,
                               const v1::TrainingState& state) {
  SINEW_RETURN_IF_ERROR(networks_->LoadWeights(tensors));
  SINEW_RETURN_IF_ERROR(networks_->LoadOptimiser(
      NetworkId::kPolicy, tensors, state.policy_optimiser_step()));
  return networks_->LoadOptimiser(NetworkId::kValue, tensors,
                                  state.value_optimiser_step());
}

absl::Status Ppo::InitFrom(const TensorMap& weights) {
  TensorMap own = networks_->SaveWeights();
  SINEW_RETURN_IF_ERROR(TakeWeights(graph_, weights, own));
  return BeginWith(own);
}

absl::Status Ppo::InitFromPrimitives(absl::Span<const Primitive> primitives) {
  if (!recipe_.network().has_composer()) {
    return absl::InvalidArgumentError(
        "recipe field network.composer: expected a composer over the "
        "primitives that were given, found none");
  }
  TensorMap own = networks_->SaveWeights();
  SINEW_RETURN_IF_ERROR(TakePrimitives(primitives, own));
  return BeginWith(own);
}

// With the normaliser's statistics as if from so many rows, and at the least
// rate that KL may choose: Adam's first steps are as long as the rate, whatever
// the gradient is worth.
absl::Status Ppo::BeginWith(const TensorMap& weights) {
  SINEW_RETURN_IF_ERROR(networks_->LoadWeights(weights));
  if (recipe_.ppo().kl_target() > 0) adaptive_factor_ = kLeastRate;
  InheritNormalisers(weights, recipe_.ppo().inherited_rows(), running_.moments);
  has_primitives_ = true;
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<std::unique_ptr<PpoLearner>> PpoLearner::Create(
    const v1::Recipe& recipe, const Options& options) {
  if (options.ranks < 1) {
    return absl::InvalidArgumentError(
        absl::StrCat("ranks: expected >= 1, found ", options.ranks));
  }
  const v1::Recipe full = WithDefaults(recipe);
  SINEW_RETURN_IF_ERROR(ValidateRecipe(full));
  if (full.ppo().mirror() && !options.mirror) {
    return absl::InvalidArgumentError(
        "recipe field ppo.mirror: expected a task with a mirror, found none");
  }
  SINEW_ASSIGN_OR_RETURN(
      InitialPolicy initial,
      MakeInitialPolicy(full,
                        {.observation = options.observation_width,
                         .self_observation = options.self_observation_width,
                         .action = options.action_width}));
  SINEW_ASSIGN_OR_RETURN(
      std::unique_ptr<PpoNetworks> networks,
      PpoNetworks::Create(initial.graph, initial.weights,
                          {.device = full.device(),
                           .bfloat16 = full.ppo().bfloat16(),
                           .shards = full.ppo().shards(),
                           .ratio_clip = full.ppo().ratio_clip(),
                           .entropy_weight = full.ppo().entropy_weight(),
                           .latent_kl_weight = full.ppo().latent_kl_weight()}));
  return std::make_unique<Ppo>(full, options, std::move(initial.graph),
                               std::move(networks));
}

}  // namespace sinew::learner
