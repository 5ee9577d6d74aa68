#include "learner/procedure/stage_recipe.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "common/config/recipe.h"

namespace sinew::learner {
namespace {

// 2^64 divided by the golden ratio: no two stages of recipes with small seeds
// have the same one.
constexpr uint64_t kSeedStep = 0x9E3779B97F4A7C15u;

int64_t SamplesOf(const v1::Procedure& procedure, const Stage& stage) {
  switch (stage.kind) {
    case StageKind::kFull:
      return procedure.full_samples();
    case StageKind::kHard:
    case StageKind::kGrown:
      return procedure.hard_samples();
    case StageKind::kRecovery:
      return procedure.recovery_samples();
    case StageKind::kComposer:
      return procedure.composer_samples();
    case StageKind::kSingle:
      return stage.samples;
  }
  return 0;
}

int64_t DivideUp(int64_t a, int64_t b) { return a / b + (a % b != 0 ? 1 : 0); }

int64_t SamplesOfIteration(const v1::Rollouts& rollouts) {
  return int64_t{rollouts.environments()} * rollouts.horizon();
}

// Of the starts of a stage on some clips, what the others get.
double OtherClipsShare(const Stage& stage, const v1::Procedure& procedure) {
  return stage.kind == StageKind::kHard ? procedure.rehearsal_share() : 0;
}

// How many times as large the iterations of a stage on a hard set are.
int64_t Enlargement(const Stage& stage, const v1::Recipe& recipe) {
  const double asked = static_cast<double>(stage.clips.size()) *
                       recipe.procedure().environments_per_clip() /
                       (1 - OtherClipsShare(stage, recipe.procedure()));
  const int32_t environments = recipe.rollouts().environments();
  return std::clamp<int64_t>(
      static_cast<int64_t>(
          std::ceil(std::min<double>(asked, kMostEnvironments) / environments)),
      1,
      std::min(kMostEnvironments / environments,
               std::numeric_limits<int32_t>::max() / recipe.ppo().minibatch()));
}

// Larger iterations of as many minibatches. Evaluations and checkpoints are
// some samples apart, not some iterations.
void Enlarge(int64_t factor, v1::Recipe& recipe) {
  v1::Rollouts& rollouts = *recipe.mutable_rollouts();
  rollouts.set_environments(
      static_cast<int32_t>(factor * rollouts.environments()));
  rollouts.set_replay_bytes(factor > std::numeric_limits<int64_t>::max() /
                                         rollouts.replay_bytes()
                                ? std::numeric_limits<int64_t>::max()
                                : factor * rollouts.replay_bytes());
  v1::Ppo& ppo = *recipe.mutable_ppo();
  ppo.set_minibatch(static_cast<int32_t>(factor * ppo.minibatch()));
  const auto part = [factor](int32_t interval, int32_t least) {
    return std::max(least, static_cast<int32_t>(interval / factor));
  };
  v1::Evaluation& evaluation = *recipe.mutable_evaluation();
  if (evaluation.interval() > 0) {
    evaluation.set_interval(part(evaluation.interval(), evaluation.delay()));
  }
  v1::Checkpointing& checkpointing = *recipe.mutable_checkpointing();
  checkpointing.set_interval(part(checkpointing.interval(), 1));
}

void SetComposer(const v1::Procedure& procedure, int primitives,
                 v1::Network& network) {
  v1::Composer& composer = *network.mutable_composer();
  composer.set_primitives(primitives);
  *composer.mutable_hidden() = procedure.composer_hidden();
}

// Whether a stage may start on the floor or from afar.
bool Recovers(const v1::Recipe& recipe, StageKind kind) {
  const v1::Recovery& recovery = recipe.task().recovery();
  return (kind == StageKind::kRecovery || kind == StageKind::kComposer) &&
         recipe.procedure().recovery_samples() > 0 &&
         RecoveryShare(recovery) > 0;
}

// Evaluations neither end it nor begin its annealing.
void IgnoreEvaluations(v1::Recipe& recipe) {
  recipe.clear_plateau();
  v1::Anneal& anneal = *recipe.mutable_ppo()->mutable_anneal();
  anneal.set_success_share(0);
  anneal.set_stall_evaluations(0);
}

// What counts of a stage are its last weights. An update learns with what the
// iterations before it have annealed to, so annealing is over before the last.
void SettleBeforeLast(const v1::Rollouts& rollouts, int64_t iterations,
                      v1::Anneal& anneal) {
  if (anneal.std_factor() == 1 && anneal.learning_rate_factor() == 1) return;
  const int64_t annealed =
      DivideUp(anneal.samples(), SamplesOfIteration(rollouts));
  anneal.set_begin_iteration(std::max<int64_t>(1, iterations - 1 - annealed));
}

}  // namespace

v1::Recipe StageRecipe(const v1::Recipe& recipe, const Stage& stage,
                       int index) {
  v1::Recipe derived = recipe;
  derived.clear_procedure();
  derived.set_max_minutes(0);
  const int64_t samples = SamplesOf(recipe.procedure(), stage);
  if (IsOnHardSet(stage.kind)) {
    Enlarge(Enlargement(stage, recipe), derived);
  }
  derived.set_max_iterations(
      DivideUp(samples, SamplesOfIteration(derived.rollouts())));
  derived.set_seed(recipe.seed() + kSeedStep * static_cast<uint64_t>(index));
  if (!recipe.name().empty()) {
    derived.set_name(absl::StrCat(recipe.name(), "_", StageName(stage)));
  }
  if (!stage.clips.empty()) {
    v1::Start& start = *derived.mutable_task()->mutable_start();
    *start.mutable_only_clips() = {stage.clips.begin(), stage.clips.end()};
    start.set_other_clips_share(OtherClipsShare(stage, recipe.procedure()));
  }
  const bool recovers = Recovers(recipe, stage.kind);
  const bool single = stage.kind == StageKind::kSingle;
  if (!recovers) derived.mutable_task()->clear_recovery();
  if (recovers || single) IgnoreEvaluations(derived);
  SettleBeforeLast(derived.rollouts(), derived.max_iterations(),
                   *derived.mutable_ppo()->mutable_anneal());
  // Its value network comes from an earlier stage, and so do its rewards.
  if (IsOnHardSet(stage.kind) || single) {
    derived.mutable_ppo()->set_value_warmup_iterations(0);
  }
  if (stage.kind == StageKind::kComposer) {
    SetComposer(recipe.procedure(), stage.primitive,
                *derived.mutable_network());
  }
  return WithDefaults(std::move(derived));
}

absl::Status ValidateStages(const v1::Recipe& recipe) {
  const v1::Procedure& procedure = recipe.procedure();
  const int trackers = procedure.max_primitives();
  const int all = trackers + (procedure.recovery_samples() > 0 ? 1 : 0);
  std::vector<Stage> stages(2);
  stages[1].kind = StageKind::kHard;
  if (procedure.recovery_samples() > 0) {
    stages.push_back({.kind = StageKind::kRecovery,
                      .primitive = trackers,
                      .clips = {},
                      .primitives = {}});
  }
  if (procedure.composer_samples() > 0) {
    stages.push_back({.kind = StageKind::kComposer,
                      .primitive = all,
                      .clips = {},
                      .primitives = {}});
  }
  if (procedure.compare_single()) {
    stages.push_back({.kind = StageKind::kSingle,
                      .from = 0,
                      .clips = {},
                      .primitives = {},
                      .samples = procedure.hard_samples()});
  }
  for (const Stage& stage : stages) {
    const absl::Status status = ValidateRecipe(StageRecipe(recipe, stage, 0));
    if (!status.ok()) {
      return absl::InvalidArgumentError(
          absl::StrCat("stage ", StageName(stage), ": ", status.message()));
    }
  }
  return absl::OkStatus();
}

}  // namespace sinew::learner
