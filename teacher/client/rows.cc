#include "teacher/client/rows.h"

#include <cmath>
#include <cstddef>

#include "absl/strings/str_cat.h"
#include "common/finite.h"
#include "common/status_macros.h"

namespace sinew::teacher {
namespace {

// Names the number that AllFinite has found.
template <typename T>
absl::Status NotFinite(absl::string_view name, absl::Span<const T> values,
                       int64_t width) {
  size_t i = 0;
  while (std::isfinite(values[i])) ++i;
  return absl::InvalidArgumentError(
      absl::StrCat(name, ": expected finite numbers, found ", values[i],
                   " in row ", i / width, ", column ", i % width));
}

absl::Status WrongSize(absl::string_view name, size_t expected, size_t found) {
  return absl::InvalidArgumentError(
      absl::StrCat(name, ": expected ", expected, " numbers, found ", found));
}

}  // namespace

absl::Status CheckFiniteRows(absl::string_view name,
                             absl::Span<const float> values, int64_t width) {
  if (AllFinite32(Bytes(values))) return absl::OkStatus();
  return NotFinite(name, values, width);
}

absl::Status CheckFiniteRows(absl::string_view name,
                             absl::Span<const double> values, int64_t width) {
  if (AllFinite64(Bytes(values))) return absl::OkStatus();
  return NotFinite(name, values, width);
}

absl::StatusOr<int64_t> CountRows(const v1::DescribeTeacherResponse& teacher,
                                  const Rows& rows,
                                  absl::Span<const double> targets) {
  const int64_t observation = teacher.observation_width();
  const int64_t action = teacher.action_width();
  const auto numbers = static_cast<int64_t>(rows.observations.size());
  if (numbers % observation != 0) {
    return absl::InvalidArgumentError(
        absl::StrCat("observations: expected rows of the teacher's ",
                     observation, " columns, found ", numbers, " numbers"));
  }
  const int64_t count = numbers / observation;
  const auto expected = static_cast<size_t>(count * action);
  if (rows.bases.size() != expected) {
    return WrongSize("bases", expected, rows.bases.size());
  }
  if (targets.size() != expected) {
    return WrongSize("targets", expected, targets.size());
  }
  return count;
}

absl::Status CheckFinite(const v1::DescribeTeacherResponse& teacher,
                         const Rows& rows, int64_t first, int64_t count) {
  if (rows.known_finite) return absl::OkStatus();
  const int64_t observation = teacher.observation_width();
  const int64_t action = teacher.action_width();
  if (AllFinite32(Bytes(rows.observations.subspan(first * observation,
                                                  count * observation))) &&
      AllFinite64(Bytes(rows.bases.subspan(first * action, count * action)))) {
    return absl::OkStatus();
  }
  SINEW_RETURN_IF_ERROR(
      CheckFiniteRows("observations", rows.observations, observation));
  return CheckFiniteRows("bases", rows.bases, action);
}

absl::StatusOr<int64_t> CheckRows(const v1::DescribeTeacherResponse& teacher,
                                  const Rows& rows,
                                  absl::Span<const double> targets) {
  SINEW_ASSIGN_OR_RETURN(const int64_t count,
                         CountRows(teacher, rows, targets));
  SINEW_RETURN_IF_ERROR(CheckFinite(teacher, rows, 0, count));
  return count;
}

}  // namespace sinew::teacher
