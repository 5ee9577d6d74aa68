#include "teacher/column_annotator.h"

#include <utility>

#include "absl/strings/str_cat.h"
#include "common/status_macros.h"
#include "teacher/client/rows.h"

namespace sinew::teacher {

absl::StatusOr<std::unique_ptr<ColumnAnnotator>> ColumnAnnotator::Create(
    std::unique_ptr<Annotator> teacher, std::vector<int32_t> columns,
    int64_t observation_width) {
  const v1::DescribeTeacherResponse& seen = teacher->description();
  if (static_cast<int64_t>(columns.size()) != seen.observation_width()) {
    return absl::InvalidArgumentError(absl::StrCat(
        "teacher ", seen.bundle_sha256(), ": expected ",
        seen.observation_width(), " columns, found ", columns.size()));
  }
  for (const int32_t column : columns) {
    if (column >= 0 && column < observation_width) continue;
    return absl::InvalidArgumentError(
        absl::StrCat("teacher ", seen.bundle_sha256(), ": expected columns of ",
                     observation_width, ", found column ", column));
  }
  return std::unique_ptr<ColumnAnnotator>(new ColumnAnnotator(
      std::move(teacher), std::move(columns), observation_width));
}

ColumnAnnotator::ColumnAnnotator(std::unique_ptr<Annotator> teacher,
                                 std::vector<int32_t> columns,
                                 int64_t observation_width)
    : teacher_(std::move(teacher)),
      columns_(std::move(columns)),
      description_(teacher_->description()) {
  description_.set_observation_width(observation_width);
  description_.clear_observation();
}

absl::Status ColumnAnnotator::Annotate(const Rows& rows,
                                       absl::Span<double> targets) {
  SINEW_ASSIGN_OR_RETURN(const int64_t count,
                         CheckRows(description_, rows, targets));
  std::vector<float> seen;
  seen.reserve(static_cast<size_t>(count) * columns_.size());
  for (int64_t row = 0; row < count; ++row) {
    const float* const all =
        rows.observations.data() + row * description_.observation_width();
    for (const int32_t column : columns_) seen.push_back(all[column]);
  }
  Rows shown = rows;
  shown.observations = seen;
  shown.known_finite = true;
  return teacher_->Annotate(shown, targets);
}

}  // namespace sinew::teacher
