#include "tools/evaluation/fallen_figures.h"

#include <algorithm>
#include <optional>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "actor/fallen_evaluation.h"
#include "common/config/recipe.h"
#include "common/status_macros.h"
#include "sim/character/character.h"
#include "tools/evaluation/rollout_pool.h"

namespace sinew::evaluation {
namespace {

constexpr double kSoonSeconds = 3;

// Neighbours of one clip run together; results say which state they are of.
absl::StatusOr<std::vector<v1::EvaluationStart>> StartsByClip(
    const world::TrackingTask& task) {
  SINEW_ASSIGN_OR_RETURN(std::vector<v1::EvaluationStart> starts,
                         actor::FallenStarts(task, kLateSeconds));
  std::sort(starts.begin(), starts.end(), [](const auto& a, const auto& b) {
    return std::make_pair(a.clip(), a.fallen_state()) <
           std::make_pair(b.clip(), b.fallen_state());
  });
  return starts;
}

// Of starts that are sorted by clip.
int CountClips(const std::vector<v1::EvaluationStart>& starts) {
  int count = 0;
  for (size_t i = 0; i < starts.size(); ++i) {
    if (i == 0 || starts[i].clip() != starts[i - 1].clip()) ++count;
  }
  return count;
}

absl::StatusOr<FallenFigures> Measure(
    const Subject& subject, const actor::PreparedSnapshot& policy,
    const std::vector<v1::EvaluationStart>& starts, int threads,
    const StopToken& stop) {
  SINEW_ASSIGN_OR_RETURN(
      const std::vector<v1::EvaluationResult> results,
      RunStarts(subject.assets, policy, starts, threads, stop));
  return FiguresOf(results, subject.assets->recipe().physics().control_hz());
}

absl::StatusOr<std::optional<FallenEvaluation::GetUp>> MeasureGetUps(
    const Subject& subject, int threads, const StopToken& stop) {
  const world::TrackingTask& task = subject.assets->task();
  if (task.num_get_up_frames() == 0) return std::nullopt;
  SINEW_ASSIGN_OR_RETURN(const std::vector<v1::EvaluationStart> starts,
                         actor::GetUpStarts(task, kLateSeconds));
  FallenEvaluation::GetUp get_up;
  get_up.reference_stands_seconds =
      starts.front().recovery_steps() / task.recipe().physics().control_hz();
  SINEW_ASSIGN_OR_RETURN(
      get_up.policy, Measure(subject, *subject.policy, starts, threads, stop));
  SINEW_ASSIGN_OR_RETURN(
      get_up.zero_action,
      Measure(subject, *subject.zero_action, starts, threads, stop));
  return get_up;
}

}  // namespace

FallenFigures FiguresOf(const std::vector<v1::EvaluationResult>& results,
                        double control_hz) {
  FallenFigures figures = {
      .recovered_3_s = actor::RecoveredShare(results, kSoonSeconds, control_hz),
      .recovered_5_s =
          actor::RecoveredShare(results, kLateSeconds, control_hz)};
  for (const v1::EvaluationResult& result : results) {
    FallenRow& row = figures.rows.emplace_back();
    row.state = result.fallen_state();
    row.clip = result.clip();
    row.seconds = result.frames() / control_hz;
    if (result.recovered_at_frame() > 0) {
      row.recovered_s = result.recovered_at_frame() / control_hz;
    }
    if (result.carried_size() > 0) {
      row.carried_s = result.carried(0).after_frames() / control_hz;
    }
  }
  std::sort(
      figures.rows.begin(), figures.rows.end(),
      [](const FallenRow& a, const FallenRow& b) { return a.state < b.state; });
  return figures;
}

absl::Status CheckFallenStarts(int starts) {
  if (starts >= 1 && starts <= kMostFallenStarts) return absl::OkStatus();
  return absl::InvalidArgumentError(absl::StrCat(
      "fallen starts: expected 1 to ", kMostFallenStarts, ", found ", starts));
}

absl::StatusOr<std::unique_ptr<const world::FallenStates>> MakeFallenStates(
    const std::string& character, int starts) {
  const v1::Recipe recipe = WithDefaults(v1::Recipe());
  SINEW_ASSIGN_OR_RETURN(
      const auto body, character::Character::Load(character, recipe.physics()));
  SINEW_ASSIGN_OR_RETURN(
      world::FallenStates states,
      world::FallenStates::MakeForEvaluation(*body, recipe, starts));
  return std::make_unique<const world::FallenStates>(std::move(states));
}

absl::StatusOr<FallenEvaluation> EvaluateFallen(const Subject& subject,
                                                int threads,
                                                const StopToken& stop) {
  const world::TrackingTask& task = subject.assets->task();
  SINEW_ASSIGN_OR_RETURN(const std::vector<v1::EvaluationStart> starts,
                         StartsByClip(task));
  const double hz = task.recipe().physics().control_hz();
  FallenEvaluation evaluation;
  evaluation.starts = static_cast<int>(starts.size());
  evaluation.seed = world::FallenStates::kEvaluationSeed;
  evaluation.clips = CountClips(starts);
  evaluation.seconds = starts.front().steps() / hz;
  evaluation.reference_stands_seconds = starts.front().recovery_steps() / hz;
  SINEW_ASSIGN_OR_RETURN(evaluation.policy, Measure(subject, *subject.policy,
                                                    starts, threads, stop));
  SINEW_ASSIGN_OR_RETURN(
      evaluation.zero_action,
      Measure(subject, *subject.zero_action, starts, threads, stop));
  SINEW_ASSIGN_OR_RETURN(evaluation.get_up,
                         MeasureGetUps(subject, threads, stop));
  return evaluation;
}

}  // namespace sinew::evaluation
