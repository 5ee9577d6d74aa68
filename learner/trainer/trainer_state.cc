#include <cstdint>
#include <deque>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/string_view.h"
#include "common/config/recipe.h"
#include "common/digest.h"
#include "common/status_macros.h"
#include "learner/trainer/trainer.h"

namespace sinew::learner {
namespace {

constexpr int kFormatVersion = 1;

absl::Status Differs(absl::string_view what, absl::string_view expected,
                     absl::string_view found) {
  return absl::FailedPreconditionError(absl::StrCat(
      "training state: ", what, ": expected ", expected, ", found ", found));
}

std::string RecipeSha256(const v1::Recipe& recipe) {
  return Sha256Hex(PrintRecipe(recipe));
}

// Whether the state is of this format and this recipe.
absl::Status CheckRecipe(const Trainer::Options& options,
                         const v1::TrainingState& state) {
  if (state.format_version() != kFormatVersion) {
    return Differs("format_version", absl::StrCat(kFormatVersion),
                   absl::StrCat(state.format_version()));
  }
  const std::string recipe = RecipeSha256(options.recipe);
  if (state.recipe_sha256() != recipe) {
    return Differs("recipe (it has changed since the run began): SHA-256",
                   state.recipe_sha256(), recipe);
  }
  return absl::OkStatus();
}

// Whether the state was written by a run of these options.
absl::Status CheckIdentity(const Trainer::Options& options,
                           const v1::TrainingState& state) {
  SINEW_RETURN_IF_ERROR(CheckRecipe(options, state));
  if (state.assets_sha256() != options.assets_sha256) {
    return Differs(
        "assets (character or motions have changed since the run began): "
        "SHA-256",
        state.assets_sha256(), options.assets_sha256);
  }
  if (state.run_id() != options.run_id) {
    return Differs("run_id", options.run_id, state.run_id());
  }
  return absl::OkStatus();
}

absl::StatusOr<std::deque<PublishedSnapshot>> ParseSnapshots(
    const Trainer::State& state) {
  const auto& references = state.counters.snapshots();
  if (references.size() != static_cast<int>(state.snapshots.size()) ||
      references.empty()) {
    return Differs("number of snapshots",
                   absl::StrCat("as many as are named, and >= 1 (",
                                references.size(), ")"),
                   absl::StrCat(state.snapshots.size()));
  }
  std::deque<PublishedSnapshot> snapshots;
  for (int i = 0; i < references.size(); ++i) {
    PublishedSnapshot& snapshot = snapshots.emplace_back();
    snapshot.bytes = state.snapshots[i];
    snapshot.sha256 = Sha256Hex(snapshot.bytes);
    if (snapshot.sha256 != references[i].sha256() ||
        !snapshot.snapshot.ParseFromString(snapshot.bytes)) {
      return Differs(
          absl::StrCat("snapshot ", references[i].version(), ": SHA-256"),
          references[i].sha256(), snapshot.sha256);
    }
  }
  return snapshots;
}

}  // namespace

std::string MakeRunId(const v1::Recipe& recipe,
                      const std::string& assets_sha256) {
  return Sha256Hex(absl::StrCat(PrintRecipe(recipe), "\n", assets_sha256));
}

Trainer::State Trainer::Save() const {
  State state;
  v1::TrainingState& counters = state.counters;
  counters.set_format_version(kFormatVersion);
  counters.set_run_id(options_.run_id);
  counters.set_iteration(iteration_);
  counters.set_samples(samples_);
  counters.set_next_order_id(planner_.next_order_id());
  counters.mutable_environments()->Assign(planner_.environments().begin(),
                                          planner_.environments().end());
  counters.mutable_open_orders()->Assign(open_orders_.begin(),
                                         open_orders_.end());
  for (const PublishedSnapshot& snapshot : snapshots_) {
    auto& reference = *counters.add_snapshots();
    reference.set_version(snapshot.snapshot.version());
    reference.set_sha256(snapshot.sha256);
    state.snapshots.push_back(snapshot.bytes);
  }
  *counters.mutable_curriculum() = curriculum_->table();
  *counters.mutable_anneal() = annealer_.state();
  if (plateau_.enabled()) *counters.mutable_plateau() = plateau_.state();
  for (const v1::PendingEvaluation& pending : pending_) {
    *counters.add_pending_evaluations() = pending;
  }
  counters.set_recipe_sha256(RecipeSha256(options_.recipe));
  counters.set_assets_sha256(options_.assets_sha256);
  learner_->SaveCounters(counters);
  state.tensors = learner_->SaveTensors();
  state.chunks = learner_->SaveChunks();
  return state;
}

absl::Status Trainer::Restore(const State& state) {
  const v1::TrainingState& counters = state.counters;
  SINEW_RETURN_IF_ERROR(CheckIdentity(options_, counters));
  SINEW_ASSIGN_OR_RETURN(std::deque<PublishedSnapshot> snapshots,
                         ParseSnapshots(state));
  SINEW_RETURN_IF_ERROR(curriculum_->Restore(counters.curriculum()));
  SINEW_RETURN_IF_ERROR(planner_.Restore(
      std::vector<v1::EnvironmentState>(counters.environments().begin(),
                                        counters.environments().end()),
      counters.next_order_id()));
  SINEW_RETURN_IF_ERROR(RestoreLearning(state));
  snapshots_ = std::move(snapshots);
  open_orders_.assign(counters.open_orders().begin(),
                      counters.open_orders().end());
  pending_.assign(counters.pending_evaluations().begin(),
                  counters.pending_evaluations().end());
  return BeginAgain();
}

absl::Status Trainer::RestoreLearning(const State& state) {
  const v1::TrainingState& counters = state.counters;
  SINEW_RETURN_IF_ERROR(learner_->Load(state.tensors, counters, state.chunks));
  annealer_.Restore(counters.anneal());
  plateau_.Restore(counters.plateau());
  iteration_ = counters.iteration();
  samples_ = counters.samples();
  learner_->SetFactors(annealer_.StdFactor(samples_),
                       annealer_.LearningRateFactor(samples_));
  return absl::OkStatus();
}

std::vector<v1::EnvironmentState> Trainer::NextEpisodes(
    const v1::TrainingState& counters) {
  std::vector<v1::EnvironmentState> environments;
  for (const v1::EnvironmentState& old : counters.environments()) {
    environments.emplace_back().set_episode(old.episode() +
                                            (old.physics().empty() ? 0 : 1));
  }
  return environments;
}

absl::StatusOr<int> Trainer::Migrate(const State& state) {
  const v1::TrainingState& counters = state.counters;
  SINEW_RETURN_IF_ERROR(CheckRecipe(options_, counters));
  SINEW_RETURN_IF_ERROR(
      planner_.Restore(NextEpisodes(counters), counters.next_order_id()));
  SINEW_RETURN_IF_ERROR(RestoreLearning(state));
  annealer_.Migrate();
  plateau_.Migrate();
  const int adopted = curriculum_->Adopt(counters.curriculum());
  snapshots_.clear();
  open_orders_.clear();
  pending_.clear();
  SINEW_RETURN_IF_ERROR(PublishSnapshot());
  return adopted;
}

// What was out is run again: a rollout is a pure function.
absl::Status Trainer::BeginAgain() {
  for (const PublishedSnapshot& snapshot : snapshots_) {
    SINEW_RETURN_IF_ERROR(experience_.Publish(snapshot));
  }
  if (!open_orders_.empty()) {
    SINEW_RETURN_IF_ERROR(experience_.Begin(open_orders_));
  }
  for (const v1::PendingEvaluation& pending : pending_) {
    SINEW_RETURN_IF_ERROR(
        experience_.Begin({pending.orders().begin(), pending.orders().end()}));
  }
  return absl::OkStatus();
}

}  // namespace sinew::learner
