#include "learner/distillation/labels.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/string_view.h"
#include "absl/types/span.h"
#include "common/segment/episode_actor.h"
#include "common/segment/row_episodes.h"
#include "common/segment/segment_layout.h"
#include "common/status_macros.h"
#include "teacher/client/rows.h"

namespace sinew::learner {
namespace {

// Valid rows, as the segment has them: one step's environments after another's.
std::vector<int64_t> ValidRows(const SegmentView& view) {
  std::vector<int64_t> rows;
  for (int64_t row = 0; row < view.rows(); ++row) {
    if (view.valid[row] != 0) rows.push_back(row);
  }
  return rows;
}

// A column of that width has finite numbers alone.
template <typename T>
absl::Status CheckNumbers(const v1::Segment& segment, absl::string_view name,
                          int64_t width) {
  const absl::Span<const T> numbers = ColumnOf<T>(segment, name);
  for (size_t i = 0; i < numbers.size(); ++i) {
    if (std::isfinite(numbers[i])) continue;
    return AtOrder(segment,
                   absl::InvalidArgumentError(absl::StrCat(
                       "segment column ", name, ": row ", i / width,
                       ": expected a finite number, found ", numbers[i])));
  }
  return absl::OkStatus();
}

// The label of a joint, which a huge target puts out of float32's range.
absl::StatusOr<float> LabelOf(const v1::Segment& segment, int64_t row,
                              int64_t joint, double target, double label) {
  if (std::abs(label) <= std::numeric_limits<float>::max()) {
    return static_cast<float>(label);
  }
  return AtOrder(segment,
                 absl::InternalError(absl::StrCat(
                     "row ", row, ", joint ", joint,
                     ": expected a label within the range of float32, found ",
                     label, " units of action (target ", target, " rad)")));
}

// All targets of these segments' valid rows are finite.
absl::Status CheckTargets(absl::Span<const v1::Segment* const> segments,
                          absl::Span<const SegmentView> views, int64_t actions,
                          const std::string& teacher,
                          absl::Span<const double> targets) {
  size_t i = 0;
  for (size_t s = 0; s < segments.size(); ++s) {
    for (const int64_t row : ValidRows(views[s])) {
      for (int64_t joint = 0; joint < actions; ++joint, ++i) {
        if (std::isfinite(targets[i])) continue;
        return AtOrder(
            *segments[s],
            absl::InternalError(absl::StrCat(
                "teacher ", teacher, ": row ", row, ", joint ", joint,
                ": expected a finite target, found ", targets[i])));
      }
    }
  }
  return absl::OkStatus();
}

// Row t of environment e goes on from row t - 1.
bool IsLinked(const SegmentView& view, int64_t t, int64_t e) {
  if (t == 0) return false;
  const int64_t row = t * view.environments + e;
  const int64_t before = row - view.environments;
  return view.valid[row] != 0 && view.valid[before] != 0 &&
         view.terminated[before] == 0 && view.truncated[before] == 0;
}

}  // namespace

absl::Status CheckLabelOptions(const LabelOptions& options) {
  for (const absl::string_view name : {column::kTeacherBase, column::kBase}) {
    const auto& columns = options.layout.columns();
    const auto found =
        std::find_if(columns.begin(), columns.end(),
                     [&](const auto& one) { return one.name() == name; });
    if (found != columns.end() && found->dtype() == v1::DATA_TYPE_FLOAT64 &&
        found->lead() == v1::SegmentLayout::LEAD_STEP &&
        found->shape_size() == 1 && found->shape(0) == options.shape.action) {
      continue;
    }
    return absl::InvalidArgumentError(
        absl::StrCat("segment layout: expected a column ", name, " [T, E, ",
                     options.shape.action, "] float64, found ",
                     found == columns.end() ? "none" : "another"));
  }
  const int64_t scales = static_cast<int64_t>(options.action_scale.size());
  if (scales != options.shape.action) {
    return absl::InvalidArgumentError(
        absl::StrCat("action_scale: expected ", options.shape.action,
                     " numbers, one per joint, found ", scales));
  }
  for (const double scale : options.action_scale) {
    if (scale > 0 && std::isfinite(scale)) continue;
    return absl::InvalidArgumentError(
        absl::StrCat("action_scale: expected > 0, found ", scale));
  }
  return absl::OkStatus();
}

absl::StatusOr<SegmentView> ViewForLabels(const v1::Segment& segment,
                                          const LabelOptions& options) {
  SINEW_ASSIGN_OR_RETURN(const SegmentView view,
                         ViewSegment(segment, options.layout));
  if (view.steps != options.shape.steps) {
    return AtOrder(segment,
                   absl::InvalidArgumentError(absl::StrCat(
                       "expected rollouts.horizon = ", options.shape.steps,
                       " steps, found ", view.steps)));
  }
  SINEW_RETURN_IF_ERROR(CheckNumbers<float>(segment, column::kObservation,
                                            options.shape.observation));
  for (const absl::string_view name : {column::kTeacherBase, column::kBase}) {
    SINEW_RETURN_IF_ERROR(
        CheckNumbers<double>(segment, name, options.shape.action));
  }
  return view;
}

int64_t CountValid(const SegmentView& view) {
  return std::count_if(view.valid.begin(), view.valid.end(),
                       [](uint8_t valid) { return valid != 0; });
}

absl::StatusOr<std::vector<double>> AskTargets(
    absl::Span<const v1::Segment* const> segments,
    absl::Span<const SegmentView> views, const LabelOptions& options,
    teacher::Annotator& annotator) {
  const SequenceShape& shape = options.shape;
  std::vector<float> observations;
  std::vector<double> bases;
  std::vector<int32_t> clips;
  for (size_t s = 0; s < segments.size(); ++s) {
    const std::vector<int64_t> rows = ValidRows(views[s]);
    teacher::AppendRows(views[s].observation, shape.observation, rows,
                        observations);
    teacher::AppendRows(ColumnOf<double>(*segments[s], column::kTeacherBase),
                        shape.action, rows, bases);
    teacher::AppendRows(ColumnOf<int32_t>(*segments[s], column::kClip), 1, rows,
                        clips);
  }
  // An answer that leaves numbers out is none.
  std::vector<double> targets(bases.size(),
                              std::numeric_limits<double>::quiet_NaN());
  if (targets.empty()) return targets;
  const absl::Status asked = annotator.Annotate(
      {.observations = observations, .bases = bases, .clips = clips},
      absl::MakeSpan(targets));
  if (!asked.ok()) {
    return absl::Status(
        asked.code(),
        absl::StrCat("labels of orders ", segments.front()->order_id(), " to ",
                     segments.back()->order_id(), ": ", asked.message()));
  }
  SINEW_RETURN_IF_ERROR(CheckTargets(segments, views, shape.action,
                                     annotator.description().bundle_sha256(),
                                     targets));
  return targets;
}

absl::StatusOr<std::vector<uint8_t>> NormaliserRows(
    const v1::Segment& segment, const SegmentView& view,
    int64_t first_environment, const LabelOptions& options) {
  std::vector<uint8_t> counts(view.valid.begin(), view.valid.end());
  if (!(options.distillation.prior_share() > 0)) return counts;
  const absl::StatusOr<std::vector<int64_t>> episodes = EpisodesOfRows(segment);
  if (!episodes.ok()) return AtOrder(segment, episodes.status());
  for (int64_t row = 0; row < view.rows(); ++row) {
    const EpisodeActor actor =
        WhoActs(options.distillation, options.seed,
                first_environment + row % view.environments, (*episodes)[row]);
    if (actor == EpisodeActor::kPrior) counts[row] = 0;
  }
  return counts;
}

absl::StatusOr<LabelledSequences> LabelSegment(
    const v1::Segment& segment, const SegmentView& view,
    const LabelOptions& options, absl::Span<const double> targets) {
  const SequenceShape& shape = options.shape;
  const auto base = ColumnOf<double>(segment, column::kBase);
  LabelledSequences result;
  result.order_id = segment.order_id();
  result.observation.resize(view.rows() * shape.observation);
  result.label.resize(view.rows() * shape.action);
  result.valid.resize(view.rows());
  result.linked.resize(view.rows());
  int64_t answer = 0;
  for (int64_t row = 0; row < view.rows(); ++row) {
    const int64_t t = row / view.environments;
    const int64_t e = row % view.environments;
    const int64_t place = e * shape.steps + t;
    const auto seen =
        view.observation.subspan(row * shape.observation, shape.observation);
    std::copy(seen.begin(), seen.end(),
              result.observation.begin() + place * shape.observation);
    result.linked[place] = IsLinked(view, t, e) ? 1.0F : 0.0F;
    if (view.valid[row] == 0) continue;
    result.valid[place] = 1;
    for (int64_t a = 0; a < shape.action; ++a) {
      const double target = targets[answer * shape.action + a];
      SINEW_ASSIGN_OR_RETURN(result.label[place * shape.action + a],
                             LabelOf(segment, row, a, target,
                                     (target - base[row * shape.action + a]) /
                                         options.action_scale[a]));
    }
    ++answer;
  }
  return result;
}

}  // namespace sinew::learner
