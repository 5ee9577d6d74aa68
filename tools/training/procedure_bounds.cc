#include "tools/training/procedure_bounds.h"

#include <algorithm>

#include "absl/strings/str_format.h"

namespace sinew::tools {
namespace {

// Of sums of seconds, which are rounded.
constexpr double kRounding = 1e-6;

}  // namespace

ProcedureBounds::ProcedureBounds(const TrainingRun::Options& options)
    : minutes_(options.minutes > 0 ? options.minutes
                                   : options.recipe.max_minutes()),
      iterations_(options.iterations > 0 ? options.iterations
                                         : options.recipe.max_iterations()) {}

void ProcedureBounds::Spend(double train_seconds, int64_t iterations) {
  spent_seconds_ += train_seconds;
  spent_iterations_ += iterations;
}

std::string ProcedureBounds::Reached() const {
  if (minutes_ > 0 && spent_seconds_ + kRounding >= 60 * minutes_) {
    return absl::StrFormat(
        "%g minutes of all stages are over: give more --minutes", minutes_);
  }
  if (iterations_ > 0 && spent_iterations_ >= iterations_) {
    return absl::StrFormat(
        "%d iterations of all stages are over: give more --iterations",
        iterations_);
  }
  return "";
}

void ProcedureBounds::Limit(TrainingRun::Options& stage) const {
  if (minutes_ > 0) stage.minutes = minutes_ - spent_seconds_ / 60;
  if (iterations_ > 0) {
    stage.iterations = std::min(iterations_ - spent_iterations_,
                                stage.recipe.max_iterations());
  }
}

ProcedureBounds BoundsAfter(const TrainingRun::Options& options,
                            const std::vector<learner::FinishedStage>& ended) {
  ProcedureBounds bounds(options);
  for (const learner::FinishedStage& stage : ended) {
    bounds.Spend(stage.train_seconds, stage.iterations);
  }
  return bounds;
}

}  // namespace sinew::tools
