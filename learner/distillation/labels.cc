#include "learner/distillation/labels.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/string_view.h"
#include "absl/types/span.h"
#include "common/segment/segment_layout.h"
#include "common/status_macros.h"

namespace sinew::learner {
namespace {

constexpr absl::string_view kTeacherBase = "teacher_base";
constexpr absl::string_view kBase = "base";

// A column that ViewSegment has checked. Protobuf's strings are aligned for any
// number.
absl::Span<const double> Doubles(const v1::Segment& segment,
                                 absl::string_view name) {
  const std::string& data = FindColumn(segment, name)->data();
  return {reinterpret_cast<const double*>(data.data()),
          data.size() / sizeof(double)};
}

absl::Status AtOrder(const v1::Segment& segment, const absl::Status& status) {
  return absl::Status(status.code(), absl::StrCat("order ", segment.order_id(),
                                                  ": ", status.message()));
}

// Valid rows, as the segment has them: one step's environments after another's.
std::vector<int64_t> ValidRows(const SegmentView& view) {
  std::vector<int64_t> rows;
  for (int64_t row = 0; row < view.rows(); ++row) {
    if (view.valid[row] != 0) rows.push_back(row);
  }
  return rows;
}

// The rows of a column of that width, one behind the other.
template <typename T>
std::vector<T> Gather(absl::Span<const T> column, int64_t width,
                      absl::Span<const int64_t> rows) {
  std::vector<T> gathered;
  gathered.reserve(rows.size() * width);
  for (const int64_t row : rows) {
    const auto values = column.subspan(row * width, width);
    gathered.insert(gathered.end(), values.begin(), values.end());
  }
  return gathered;
}

absl::Status Ask(teacher::Annotator& annotator, const SequenceShape& shape,
                 absl::Span<const float> observations,
                 absl::Span<const double> bases, absl::Span<double> targets) {
  const int32_t limit = annotator.description().max_rows();
  const int64_t rows = static_cast<int64_t>(targets.size()) / shape.action;
  const int64_t step = limit > 0 ? limit : rows;
  for (int64_t first = 0; first < rows; first += step) {
    const int64_t count = std::min(step, rows - first);
    const auto part = [&](auto span, int64_t width) {
      return span.subspan(first * width, count * width);
    };
    SINEW_RETURN_IF_ERROR(annotator.Annotate(
        {.observations = part(observations, shape.observation),
         .bases = part(bases, shape.action)},
        part(targets, shape.action)));
  }
  return absl::OkStatus();
}

// Targets [rows, A] of these rows of the segment.
absl::StatusOr<std::vector<double>> Targets(const v1::Segment& segment,
                                            const SegmentView& view,
                                            absl::Span<const int64_t> rows,
                                            const SequenceShape& shape,
                                            teacher::Annotator& annotator) {
  // An answer that leaves numbers out is none.
  std::vector<double> targets(rows.size() * shape.action,
                              std::numeric_limits<double>::quiet_NaN());
  const absl::Status asked =
      Ask(annotator, shape, Gather(view.observation, shape.observation, rows),
          Gather(Doubles(segment, kTeacherBase), shape.action, rows),
          absl::MakeSpan(targets));
  if (!asked.ok()) return AtOrder(segment, asked);
  for (size_t i = 0; i < targets.size(); ++i) {
    if (std::isfinite(targets[i])) continue;
    return AtOrder(
        segment,
        absl::InternalError(absl::StrCat(
            "teacher ", annotator.description().bundle_sha256(), ": row ",
            rows[i / shape.action], ", joint ", i % shape.action,
            ": expected a finite target, found ", targets[i])));
  }
  return targets;
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
  for (const absl::string_view name : {kTeacherBase, kBase}) {
    const auto& columns = options.layout.columns();
    const auto found =
        std::find_if(columns.begin(), columns.end(),
                     [&](const auto& column) { return column.name() == name; });
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
  if (view.steps == options.shape.steps) return view;
  return AtOrder(segment,
                 absl::InvalidArgumentError(absl::StrCat(
                     "expected rollouts.horizon = ", options.shape.steps,
                     " steps, found ", view.steps)));
}

absl::StatusOr<LabelledSequences> LabelSegment(const v1::Segment& segment,
                                               const SegmentView& view,
                                               const LabelOptions& options,
                                               teacher::Annotator& annotator) {
  const SequenceShape& shape = options.shape;
  const std::vector<int64_t> rows = ValidRows(view);
  SINEW_ASSIGN_OR_RETURN(const std::vector<double> targets,
                         Targets(segment, view, rows, shape, annotator));
  const absl::Span<const double> base = Doubles(segment, kBase);
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
      result.label[place * shape.action + a] = static_cast<float>(
          (targets[answer * shape.action + a] - base[row * shape.action + a]) /
          options.action_scale[a]);
    }
    ++answer;
  }
  return result;
}

}  // namespace sinew::learner
