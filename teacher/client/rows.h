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
// teacher's widths or each other; the first number that is not finite, by row
// and column.
absl::StatusOr<int64_t> CheckRows(const v1::DescribeTeacherResponse& teacher,
                                  const Rows& rows,
                                  absl::Span<const double> targets);

// INVALID_ARGUMENT: "NAME: expected finite numbers, found nan in row 3, column
// 7" for numbers of `width` columns.
absl::Status CheckFiniteRows(absl::string_view name,
                             absl::Span<const float> values, int64_t width);
absl::Status CheckFiniteRows(absl::string_view name,
                             absl::Span<const double> values, int64_t width);

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
