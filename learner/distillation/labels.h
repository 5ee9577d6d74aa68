#ifndef SINEW_LEARNER_DISTILLATION_LABELS_H_
#define SINEW_LEARNER_DISTILLATION_LABELS_H_

#include <cstdint>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/types/span.h"
#include "learner/memory/memory_chunk.h"
#include "learner/update/segment_view.h"
#include "proto/sinew/v1/distillation.pb.h"
#include "proto/sinew/v1/rollout.pb.h"
#include "teacher/client/annotator.h"

namespace sinew::learner {

// What turns segments into labelled sequences.
struct LabelOptions {
  // Of segments; with columns "teacher_base" and "base", [T, E, A] float64, rad
  // (common/segment/segment_layout.h).
  v1::SegmentLayout layout;
  SequenceShape shape;
  // The student's action law, [A]: radians per unit of action.
  std::vector<double> action_scale;
  // Of the recipe: who acts in which episode.
  v1::Distillation distillation = {};
  uint64_t seed = 0;
};

// INVALID_ARGUMENT if layout or scales do not fit: names what, expected and
// found.
absl::Status CheckLabelOptions(const LabelOptions& options);

// One segment, checked against the layout: horizon T, and all numbers that are
// read here are finite. INVALID_ARGUMENT names the order, and the row.
absl::StatusOr<SegmentView> ViewForLabels(const v1::Segment& segment,
                                          const LabelOptions& options);

// Asks the teacher for the targets of all valid rows of these segments, in one
// call: [rows, A] rad, segment after segment, in each one step's environments
// after another's. It is told the rows' clips. Rows that are not valid are not
// shown to the teacher.
//
// Blocking: as the annotator's. Errors: the annotator's, with the orders;
// INTERNAL for targets that are not finite, with teacher, order and row.
absl::StatusOr<std::vector<double>> AskTargets(
    absl::Span<const v1::Segment* const> segments,
    absl::Span<const SegmentView> views, const LabelOptions& options,
    teacher::Annotator& annotator);

// Rows of a segment that AskTargets asks for.
int64_t CountValid(const SegmentView& view);

// Flags [T, E] of the rows that count in the normaliser: the valid ones but for
// those of episodes in which the prior acts. These lie farther out, and by
// their spread the inputs of a student that tracks would shrink. Rows of the
// teacher's episodes count, and of bodies that the student leads on from where
// the prior left them. `first_environment` is Order.first_environment of the
// segment's. Pure. INVALID_ARGUMENT with order for end states that do not fit.
absl::StatusOr<std::vector<uint8_t>> NormaliserRows(
    const v1::Segment& segment, const SegmentView& view,
    int64_t first_environment, const LabelOptions& options);

// One segment with its targets [CountValid, A] in the student's units:
//
//   label = (target - base) / scale
//
// Pure. INTERNAL with order, row and joint for a label that float32 has not.
absl::StatusOr<LabelledSequences> LabelSegment(
    const v1::Segment& segment, const SegmentView& view,
    const LabelOptions& options, absl::Span<const double> targets);

}  // namespace sinew::learner

#endif  // SINEW_LEARNER_DISTILLATION_LABELS_H_
