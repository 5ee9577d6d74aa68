#ifndef SINEW_TEACHER_CLIENT_ROWS_H_
#define SINEW_TEACHER_CLIENT_ROWS_H_

#include <cstdint>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "absl/types/span.h"
#include "proto/sinew/v1/teacher.pb.h"
#include "teacher/client/annotator.h"

namespace sinew::teacher {

// What every annotator asks of its rows and answers. Pure, at memory speed.

// Number of rows R, 0 included. INVALID_ARGUMENT: sizes that do not fit the
// teacher's widths or each other.
absl::StatusOr<int64_t> CountRows(const v1::DescribeTeacherResponse& teacher,
                                  const Rows& rows,
                                  absl::Span<const double> targets);

// INVALID_ARGUMENT: a number of rows [first, first + count) is not finite;
// names the first one of all rows, by row and column. Does not look at rows
// that are known_finite.
absl::Status CheckFinite(const v1::DescribeTeacherResponse& teacher,
                         const Rows& rows, int64_t first, int64_t count);

// Both, of all rows.
absl::StatusOr<int64_t> CheckRows(const v1::DescribeTeacherResponse& teacher,
                                  const Rows& rows,
                                  absl::Span<const double> targets);

// INVALID_ARGUMENT: "NAME: expected finite numbers, found nan in row 3, column
// 7" for numbers of `width` columns.
absl::Status CheckFiniteRows(absl::string_view name,
                             absl::Span<const float> values, int64_t width);
absl::Status CheckFiniteRows(absl::string_view name,
                             absl::Span<const double> values, int64_t width);

// The numbers as they lie in memory.
template <typename T>
absl::string_view Bytes(absl::Span<const T> values) {
  return {reinterpret_cast<const char*>(values.data()),
          values.size() * sizeof(T)};
}

// Appends rows of `values`, which have that many columns.
template <typename T>
void AppendRows(absl::Span<const T> values, int64_t width,
                absl::Span<const int64_t> rows, std::vector<T>& into) {
  for (const int64_t row : rows) {
    const auto one = values.subspan(row * width, width);
    into.insert(into.end(), one.begin(), one.end());
  }
}

}  // namespace sinew::teacher

#endif  // SINEW_TEACHER_CLIENT_ROWS_H_
