#ifndef SINEW_TEACHER_COLUMN_ANNOTATOR_H_
#define SINEW_TEACHER_COLUMN_ANNOTATOR_H_

#include <cstdint>
#include <memory>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/types/span.h"
#include "proto/sinew/v1/teacher.pb.h"
#include "teacher/client/annotator.h"

namespace sinew::teacher {

// A teacher that sees some of the columns that its student sees, in an order of
// its own: so a student may observe more than who teaches it.
//
//   Annotate: observations [R, O] -> [R, O'], column i of O' is columns[i] of O
//
// Description: the teacher's, with the student's O for observation_width and
// no observation.
// Spread: the teacher's.
//
// Thread-safety, blocking: as the teacher. Ownership: owns it. Errors: Create;
// INVALID_ARGUMENT for rows that do not fit or are not finite, by the student's
// columns; those of the teacher.
class ColumnAnnotator final : public Annotator {
 public:
  // INVALID_ARGUMENT: as many columns as the teacher observes, each within
  // [0, observation_width), are expected.
  static absl::StatusOr<std::unique_ptr<ColumnAnnotator>> Create(
      std::unique_ptr<Annotator> teacher, std::vector<int32_t> columns,
      int64_t observation_width);

  const v1::DescribeTeacherResponse& description() const override {
    return description_;
  }
  absl::Span<const double> spread() const override {
    return teacher_->spread();
  }
  absl::Status Annotate(const Rows& rows, absl::Span<double> targets) override;

 private:
  ColumnAnnotator(std::unique_ptr<Annotator> teacher,
                  std::vector<int32_t> columns, int64_t observation_width);

  const std::unique_ptr<Annotator> teacher_;
  const std::vector<int32_t> columns_;
  v1::DescribeTeacherResponse description_;
};

}  // namespace sinew::teacher

#endif  // SINEW_TEACHER_COLUMN_ANNOTATOR_H_
