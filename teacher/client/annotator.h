#ifndef SINEW_TEACHER_CLIENT_ANNOTATOR_H_
#define SINEW_TEACHER_CLIENT_ANNOTATOR_H_

#include <cstdint>
#include <string>

#include "absl/status/status.h"
#include "absl/types/span.h"
#include "proto/sinew/v1/teacher.pb.h"

namespace sinew::teacher {

// A batch to label; borrowed for the call. R rows, O observation and A action
// columns of the teacher's description, row-major.
struct Rows {
  absl::Span<const float> observations;  // [R, O], not normalised
  absl::Span<const double> bases;        // [R, A] rad: column teacher_base
  // [R], column clip, by the run's library; or empty. What a single teacher
  // says does not depend on it.
  absl::Span<const int32_t> clips = {};
  // Whether somebody has seen already that all numbers are finite, so that
  // nobody need look again.
  bool known_finite = false;
};

// A teacher: from observations to the joint targets that it would ask for.
//
//   target_j = clamp(base_j + scale_j * clamp(mean_j, +-clip),
//                    lower_j - range_margin, upper_j + range_margin)
//
// with the bundle's action law (sim/world/action.h) and its policy's mean. In
// this process (teacher/local_annotator.h) or behind gRPC, with replicas
// (remote_annotator.h); or several of them, by clip (teacher/clip_annotator.h),
// or one that sees less than who asks (teacher/column_annotator.h). The answer
// is a function of row and bundle alone: the same bytes whoever answers and
// whatever else is in the batch.
//
// Thread-safety: any thread. Ownership: copies what it keeps. Blocking:
// Annotate, bounded by the implementation's deadline and stop token. Errors:
// INVALID_ARGUMENT for sizes that do not fit and numbers that are not finite,
// INTERNAL for a teacher whose answer is not finite, UNAVAILABLE or
// DEADLINE_EXCEEDED naming the peers where none answered; nothing of `targets`
// means anything then. Labels are never guessed.
class Annotator {
 public:
  virtual ~Annotator() = default;

  // Of the teacher; constant.
  virtual const v1::DescribeTeacherResponse& description() const = 0;
  // Standard deviation of a target around its mean, [A] rad.
  virtual absl::Span<const double> spread() const = 0;
  // Targets [R, A], rad.
  virtual absl::Status Annotate(const Rows& rows,
                                absl::Span<double> targets) = 0;
};

}  // namespace sinew::teacher

#endif  // SINEW_TEACHER_CLIENT_ANNOTATOR_H_
