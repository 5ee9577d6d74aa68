#ifndef SINEW_COMMON_SEGMENT_MIRROR_H_
#define SINEW_COMMON_SEGMENT_MIRROR_H_

#include <vector>

#include "absl/status/statusor.h"
#include "absl/types/span.h"
#include "proto/sinew/v1/rollout.pb.h"

namespace sinew {

// What a row of numbers becomes when left and right change places:
//   mirrored[i] = sign[i] * row[source[i]], sign +1 or -1.
// Applied twice it is the identity.
struct RowMirror {
  std::vector<int> source;
  std::vector<float> sign;

  int width() const { return static_cast<int>(source.size()); }
  // `row` and `mirrored` are [width] and do not overlap.
  void Apply(absl::Span<const float> row, absl::Span<float> mirrored) const;
};

// INVALID_ARGUMENT unless source is an involution and sign agrees with it;
// names the entry.
absl::Status CheckRowMirror(const RowMirror& mirror);

// Mirrors of a task's observation and action.
struct SegmentMirror {
  RowMirror observation;
  RowMirror action;
};

// The training segment that a mirrored body in a mirrored world would have
// given, had it drawn mirrored noise: observations and actions mirrored, all
// else as it was (log_probability is that of the original action; target, in
// radians and unread by learners, stays too). Twice the data for one rollout,
// exact for a policy that treats left and right alike (Abdolhosseini et al.
// 2019, "On learning symmetric locomotion", method DUP).
//
// Pure. INVALID_ARGUMENT: a column's width differs from the mirror's.
absl::StatusOr<v1::Segment> MirrorSegment(const v1::Segment& segment,
                                          const SegmentMirror& mirror);

}  // namespace sinew

#endif  // SINEW_COMMON_SEGMENT_MIRROR_H_
