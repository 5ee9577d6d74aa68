#ifndef SINEW_TEACHER_CLIP_ANNOTATOR_H_
#define SINEW_TEACHER_CLIP_ANNOTATOR_H_

#include <cstdint>
#include <memory>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/types/span.h"
#include "proto/sinew/v1/teacher.pb.h"
#include "teacher/client/annotator.h"

namespace sinew::teacher {

// One of several teachers.
struct ClipTeacher {
  std::unique_ptr<Annotator> annotator;
  // Behind gRPC: asked on a thread of its own, beside the others. Those in this
  // process share threads, and are asked one after the other.
  bool elsewhere = false;
};

// Several teachers as one: each labels the rows of its own clips. So one policy
// learns what one policy per clip knows.
//
//   Annotate: rows -> by clip, to their teachers -> their places
//
// Description: the first teacher's, with a SHA-256 over all bundles' digests in
// order (whose clips are whose is left out), and no provenance. Spread: of each
// joint, the largest of all teachers.
//
// Thread-safety, blocking: as the teachers; one that fails is told of when
// those elsewhere have answered. Ownership: owns them. Errors:
// Create; those of the teachers; INVALID_ARGUMENT for rows without Rows::clips,
// or of a clip that nobody labels.
class ClipAnnotator final : public Annotator {
 public:
  // Of a clip that nobody labels.
  static constexpr int kNone = -1;

  // `teacher_of_clip` [C]: by clip of the run's library, an index into
  // `teachers`, or kNone. INVALID_ARGUMENT: no teachers, teachers of different
  // widths, an index that is none.
  static absl::StatusOr<std::unique_ptr<ClipAnnotator>> Create(
      std::vector<ClipTeacher> teachers, std::vector<int> teacher_of_clip);

  const v1::DescribeTeacherResponse& description() const override {
    return description_;
  }
  absl::Span<const double> spread() const override { return spread_; }
  absl::Status Annotate(const Rows& rows, absl::Span<double> targets) override;

 private:
  ClipAnnotator(std::vector<ClipTeacher> teachers,
                std::vector<int> teacher_of_clip);

  // Rows of each teacher, in order.
  absl::StatusOr<std::vector<std::vector<int64_t>>> Divide(
      const Rows& rows) const;
  absl::Status Ask(Annotator& teacher, const Rows& rows,
                   absl::Span<const int64_t> of_teacher,
                   absl::Span<double> targets) const;

  const std::vector<ClipTeacher> teachers_;
  const std::vector<int> teacher_of_clip_;
  v1::DescribeTeacherResponse description_;
  std::vector<double> spread_;
};

}  // namespace sinew::teacher

#endif  // SINEW_TEACHER_CLIP_ANNOTATOR_H_
