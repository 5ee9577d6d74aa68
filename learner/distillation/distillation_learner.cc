#include "learner/distillation/distillation_learner.h"

#include <cstdint>
#include <optional>
#include <string>
#include <utility>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "common/check.h"
#include "common/config/recipe.h"
#include "common/policy/teacher_graph.h"
#include "common/status_macros.h"
#include "learner/distillation/annealing.h"
#include "learner/distillation/distillation_networks.h"
#include "learner/distillation/distillation_update.h"
#include "learner/distillation/labeller.h"
#include "learner/distillation/labels.h"
#include "learner/distillation/student_networks.h"
#include "learner/memory/memory.h"
#include "learner/torch/runtime.h"
#include "learner/update/graph_normalisers.h"
#include "learner/update/initial_weights.h"
#include "learner/update/normaliser.h"
#include "learner/update/rank_pool.h"
#include "learner/update/running_state.h"

namespace sinew::learner {
namespace {

constexpr char kSource[] = "training state";

SequenceShape ShapeOf(const v1::Recipe& recipe,
                      const DistillationLearner::Options& options) {
  return {.steps = recipe.rollouts().horizon(),
          .observation = options.observation_width,
          .action = options.action_width};
}

// Of the mirror images of the rows that these are of.
Moments Mirrored(const Moments& moments, const RowMirror& mirror) {
  Moments result(mirror.width());
  result.count = moments.count;
  for (int i = 0; i < mirror.width(); ++i) {
    result.mean[i] = mirror.sign[i] * moments.mean[mirror.source[i]];
    result.squares[i] = moments.squares[mirror.source[i]];
  }
  return result;
}

class Distillation final : public DistillationLearner {
 public:
  Distillation(const v1::Recipe& recipe, const Options& options,
               v1::PolicyGraph graph,
               std::unique_ptr<DistillationNetworks> networks)
      : recipe_(recipe),
        graph_(std::move(graph)),
        networks_(std::move(networks)),
        pool_(options.ranks, UseOneThread),
        labeller_({.layout = options.layout,
                   .shape = ShapeOf(recipe, options),
                   .action_scale = options.action_scale,
                   .distillation = recipe.distillation(),
                   .seed = recipe.seed()},
                  *options.annotator, pool_),
        memory_(
            {.seed = recipe.seed(),
             .shape = shape(),
             .samples_per_insert = recipe.distillation().samples_per_insert(),
             .recipe = recipe.distillation().memory()}),
        running_({.moments = Moments(options.observation_width)}),
        mirror_(recipe.distillation().mirror() ? options.mirror
                                               : std::nullopt) {}

  absl::Status Prepare(absl::Span<const v1::Segment* const> segments) override {
    return labeller_.Prepare(segments);
  }
  absl::StatusOr<UpdateStatistics> Update(
      absl::Span<const v1::Segment* const> segments,
      int64_t iteration) override;

  const v1::PolicyGraph& graph() const override { return graph_; }
  TensorMap weights() const override { return networks_->SaveWeights(); }

  TensorMap SaveTensors() const override {
    TensorMap tensors = networks_->SaveWeights();
    networks_->SaveOptimiser(tensors);
    SaveRunningState(running_, tensors);
    return tensors;
  }
  void SaveCounters(v1::TrainingState& state) const override {
    state.set_policy_optimiser_step(networks_->optimiser_steps());
    state.set_normaliser_count(running_.moments.count);
    memory_.Save(*state.mutable_memory());
  }
  std::vector<StateChunk> SaveChunks() const override {
    return memory_.chunks();
  }
  absl::Status Load(const TensorMap& tensors, const v1::TrainingState& state,
                    absl::Span<const StateChunk> chunks) override;

  absl::Status InitFrom(const TensorMap& weights) override {
    TensorMap own = networks_->SaveWeights();
    // The teacher is this run's own.
    TensorMap others = weights;
    std::erase_if(others, [](const auto& one) {
      return absl::StartsWith(one.first, policy::kTeacherPrefix);
    });
    SINEW_RETURN_IF_ERROR(TakeWeights(graph_, others, own));
    SINEW_RETURN_IF_ERROR(networks_->LoadWeights(own));
    InheritNormalisers(own, recipe_.distillation().inherited_rows(),
                       running_.moments);
    return absl::OkStatus();
  }

  // There is no standard deviation to lower.
  void SetFactors(double std_factor, double learning_rate_factor) override {
    running_.std_factor = std_factor;
    running_.learning_rate_factor = learning_rate_factor;
  }

 private:
  const SequenceShape& shape() const { return labeller_.options().shape; }

  absl::Status ApplyNormaliser(const std::vector<LabelledSegment>& labelled) {
    for (const LabelledSegment& one : labelled) {
      MergeMoments(one.moments, running_.moments);
      if (!mirror_) continue;
      MergeMoments(Mirrored(one.moments, mirror_->observation),
                   running_.moments);
    }
    TensorMap weights = networks_->SaveWeights();
    WriteNormalisers(running_.moments, weights);
    return networks_->LoadWeights(weights);
  }

  double learning_rate() const {
    return LearningRate(recipe_.distillation(), memory_.inserted_rows()) *
           running_.learning_rate_factor;
  }
  DistillationSettings Settings() const {
    const v1::Distillation& distillation = recipe_.distillation();
    return {.seed = recipe_.seed(),
            .shape = shape(),
            .minibatch = distillation.minibatch(),
            .shards = distillation.shards(),
            .learning_rate = learning_rate(),
            .max_gradient_norm = distillation.max_gradient_norm(),
            .kl_weight = KlWeight(distillation, memory_.inserted_rows()),
            .continuity_weight = distillation.continuity_weight(),
            .mirror = mirror_ ? &*mirror_ : nullptr};
  }
  absl::Status LoadNetworks(const TensorMap& tensors, int64_t steps) {
    SINEW_RETURN_IF_ERROR(networks_->LoadWeights(tensors));
    return networks_->LoadOptimiser(tensors, steps);
  }
  void Add(const MinibatchFigures& figures, double kl_weight,
           UpdateStatistics& statistics) const;

  const v1::Recipe recipe_;  // defaults filled
  const v1::PolicyGraph graph_;
  const std::unique_ptr<DistillationNetworks> networks_;
  RankPool pool_;
  Labeller labeller_;
  Memory memory_;
  RunningState running_;
  const std::optional<SegmentMirror> mirror_;
};

absl::StatusOr<UpdateStatistics> Distillation::Update(
    absl::Span<const v1::Segment* const> segments, int64_t /*iteration*/) {
  SINEW_ASSIGN_OR_RETURN(const std::vector<LabelledSegment> labelled,
                         labeller_.Take(segments));
  UpdateStatistics statistics = DescribeRows(segments, labeller_.options());
  statistics.policy_learning_rate = learning_rate();
  const DistillationSettings settings = Settings();
  SINEW_RETURN_IF_ERROR(ApplyNormaliser(labelled));
  for (size_t i = 0; i < segments.size(); ++i) {
    memory_.Insert(segments[i]->order_id(), labelled[i].chunk);
  }
  SINEW_ASSIGN_OR_RETURN(const MinibatchFigures figures,
                         RunMinibatches(settings, memory_, *networks_, pool_));
  Add(figures, settings.kl_weight, statistics);
  return statistics;
}

void Distillation::Add(const MinibatchFigures& figures, double kl_weight,
                       UpdateStatistics& statistics) const {
  statistics.policy_loss = figures.loss;
  statistics.policy_gradient_norm = figures.gradient_norm;
  statistics.non_finite = figures.non_finite;
  statistics.flops = figures.flops;
  DistillationFigures& distillation = statistics.distillation.emplace();
  distillation.action_loss = figures.action;
  distillation.action_error_rad = figures.action_error_rad;
  distillation.latent_kl = figures.latent_kl;
  distillation.continuity_loss = figures.continuity;
  distillation.kl_weight = kl_weight;
  distillation.memory_rows = memory_.rows();
  distillation.labelled_rows = statistics.samples;
}

absl::Status Distillation::Load(const TensorMap& tensors,
                                const v1::TrainingState& state,
                                absl::Span<const StateChunk> chunks) {
  SINEW_RETURN_IF_ERROR(CheckFinite(tensors, kSource));
  SINEW_ASSIGN_OR_RETURN(
      RunningState running,
      LoadRunningState(tensors, shape().observation, state.normaliser_count()));
  if (state.policy_optimiser_step() < 0 || !(state.normaliser_count() >= 0)) {
    return absl::InvalidArgumentError(absl::StrCat(
        kSource,
        ": expected policy_optimiser_step and normaliser_count >= "
        "0, found ",
        state.policy_optimiser_step(), " and ", state.normaliser_count()));
  }
  TensorMap before = networks_->SaveWeights();
  networks_->SaveOptimiser(before);
  const int64_t steps_before = networks_->optimiser_steps();
  absl::Status loaded = LoadNetworks(tensors, state.policy_optimiser_step());
  if (loaded.ok()) loaded = memory_.Restore(state.memory(), chunks);
  if (!loaded.ok()) {
    const absl::Status back = LoadNetworks(before, steps_before);
    SINEW_CHECK(back.ok()) << back.ToString();
    return loaded;
  }
  running_ = std::move(running);
  labeller_.Forget();
  return absl::OkStatus();
}

absl::Status CheckMirror(const v1::Recipe& recipe,
                         const DistillationLearner::Options& options) {
  if (!recipe.distillation().mirror()) return absl::OkStatus();
  if (!options.mirror) {
    return absl::InvalidArgumentError(
        "recipe field distillation.mirror: expected a task with a mirror, "
        "found none");
  }
  const int observation = options.mirror->observation.width();
  const int action = options.mirror->action.width();
  if (observation == options.observation_width &&
      action == options.action_width) {
    return absl::OkStatus();
  }
  return absl::InvalidArgumentError(
      absl::StrCat("mirror: expected ", options.observation_width,
                   " observation and ", options.action_width,
                   " action columns, found ", observation, " and ", action));
}

absl::Status CheckOptions(const v1::Recipe& recipe,
                          const DistillationLearner::Options& options) {
  if (options.ranks < 1) {
    return absl::InvalidArgumentError(
        absl::StrCat("ranks: expected >= 1, found ", options.ranks));
  }
  if (!recipe.has_distillation() || options.annotator == nullptr) {
    return absl::InvalidArgumentError(absl::StrCat(
        "recipe field distillation: expected it and a teacher, found ",
        recipe.has_distillation() ? "no teacher" : "none"));
  }
  const v1::DescribeTeacherResponse& teacher = options.annotator->description();
  if (teacher.observation_width() != options.observation_width ||
      teacher.action_width() != options.action_width) {
    return absl::InvalidArgumentError(absl::StrCat(
        "teacher ", teacher.bundle_sha256(), ": expected ",
        options.observation_width, " observation and ", options.action_width,
        " action columns, found ", teacher.observation_width(), " and ",
        teacher.action_width()));
  }
  SINEW_RETURN_IF_ERROR(CheckMirror(recipe, options));
  return CheckLabelOptions({.layout = options.layout,
                            .shape = ShapeOf(recipe, options),
                            .action_scale = options.action_scale});
}

}  // namespace

absl::StatusOr<std::unique_ptr<DistillationLearner>>
DistillationLearner::Create(const v1::Recipe& recipe, const Options& options) {
  const v1::Recipe full = WithDefaults(recipe);
  SINEW_RETURN_IF_ERROR(ValidateRecipe(full));
  SINEW_RETURN_IF_ERROR(CheckOptions(full, options));
  SINEW_ASSIGN_OR_RETURN(
      Student student,
      MakeStudent(full, options.observation_width,
                  options.self_observation_width, options.action_width));
  if (options.add_graphs) {
    SINEW_RETURN_IF_ERROR(options.add_graphs(student.graph, student.weights));
  }
  const v1::Distillation& distillation = full.distillation();
  SINEW_ASSIGN_OR_RETURN(
      std::unique_ptr<DistillationNetworks> networks,
      DistillationNetworks::Create(
          student.graph, student.weights,
          {.device = full.device(),
           .shards = distillation.shards(),
           .shard_rows = distillation.minibatch() / distillation.shards(),
           .steps = full.rollouts().horizon(),
           .form = distillation.form(),
           .bfloat16 = distillation.bfloat16(),
           .action_scale = options.action_scale}));
  return std::make_unique<Distillation>(full, options, std::move(student.graph),
                                        std::move(networks));
}

}  // namespace sinew::learner
