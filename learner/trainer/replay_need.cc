#include "learner/trainer/replay_need.h"

#include <string>

#include "absl/strings/str_cat.h"
#include "common/segment/segment_size.h"

namespace sinew::learner {
namespace {

// As OrderPlanner groups them.
double TrainingBytes(const v1::Rollouts& rollouts,
                     const v1::SegmentLayout& layout) {
  const int64_t group = rollouts.environments_per_order();
  const double orders = static_cast<double>(rollouts.environments() / group);
  return orders * static_cast<double>(
                      MaxTrainingBytes(layout, group, rollouts.horizon()));
}

double EvaluationBytes(int64_t group, int64_t starts) {
  const int64_t rest = starts % group;
  const double whole = static_cast<double>(starts / group) *
                       static_cast<double>(MaxEvaluationBytes(group));
  return rest == 0 ? whole
                   : whole + static_cast<double>(MaxEvaluationBytes(rest));
}

}  // namespace

int64_t ReplayBytesNeeded(const v1::Recipe& recipe,
                          const v1::SegmentLayout& layout,
                          int64_t evaluation_starts) {
  const v1::Rollouts& rollouts = recipe.rollouts();
  double bytes = TrainingBytes(rollouts, layout);
  if (recipe.evaluation().interval() > 0) {
    bytes +=
        EvaluationBytes(rollouts.environments_per_order(), evaluation_starts);
  }
  constexpr double kMost = int64_t{1} << 62;
  return static_cast<int64_t>(bytes < kMost ? bytes : kMost);
}

absl::Status CheckReplayHolds(const v1::Recipe& recipe,
                              const v1::SegmentLayout& layout,
                              int64_t evaluation_starts, int64_t limit_bytes) {
  const int64_t needed = ReplayBytesNeeded(recipe, layout, evaluation_starts);
  if (needed <= limit_bytes) return absl::OkStatus();
  const std::string starts =
      recipe.evaluation().interval() == 0
          ? ""
          : absl::StrCat(" and ", evaluation_starts,
                         " starts of an evaluation (evaluation.starts of each "
                         "clip)");
  return absl::InvalidArgumentError(absl::StrCat(
      "rollouts.replay_bytes (or --bytes of a replay elsewhere): expected >= ",
      needed, ", which the segments of ", recipe.rollouts().environments(),
      " environments", starts, " may need, found ", limit_bytes));
}

}  // namespace sinew::learner
