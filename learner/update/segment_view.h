#ifndef SINEW_LEARNER_UPDATE_SEGMENT_VIEW_H_
#define SINEW_LEARNER_UPDATE_SEGMENT_VIEW_H_

#include <cstdint>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "absl/types/span.h"
#include "common/segment/segment_layout.h"
#include "proto/sinew/v1/rollout.pb.h"

namespace sinew::learner {

// The columns of a training segment that updates read, without copying: T
// steps, E environments, K truncated steps; shapes and meaning are those of
// common/segment/segment_layout.h. Valid as long as the segment is.
struct SegmentView {
  int64_t steps = 0;                               // T
  int64_t environments = 0;                        // E
  absl::Span<const float> observation;             // [T, E, O]
  absl::Span<const float> action;                  // [T, E, A]
  absl::Span<const float> action_mean;             // [T, E, A]
  absl::Span<const float> log_probability;         // [T, E]
  absl::Span<const float> latent_noise;            // [T, E, Z]; empty: none
  absl::Span<const float> reward;                  // [T, E]
  absl::Span<const float> reward_terms;            // [T, E, 4]
  absl::Span<const float> body_distance;           // [T, E]
  absl::Span<const uint8_t> terminated;            // [T, E]
  absl::Span<const uint8_t> truncated;             // [T, E]
  absl::Span<const uint8_t> valid;                 // [T, E]
  absl::Span<const float> boundary_observation;    // [E, O]
  absl::Span<const int32_t> truncation_index;      // [K]
  absl::Span<const float> truncation_observation;  // [K, O]

  int64_t rows() const { return steps * environments; }
};

// Checks all columns against the layout (not that numbers are finite: replay
// has). INVALID_ARGUMENT names the order, the column, expected and found.
absl::StatusOr<SegmentView> ViewSegment(const v1::Segment& segment,
                                        const v1::SegmentLayout& layout);

// The numbers of a column that ViewSegment, or CheckColumns, has passed.
// Protobuf's strings are aligned for any number.
template <typename T>
absl::Span<const T> ColumnOf(const v1::Segment& segment,
                             absl::string_view name) {
  const std::string& data = FindColumn(segment, name)->data();
  return {reinterpret_cast<const T*>(data.data()), data.size() / sizeof(T)};
}

// "order ID: " before an error of a segment.
absl::Status AtOrder(const v1::Segment& segment, const absl::Status& status);

}  // namespace sinew::learner

#endif  // SINEW_LEARNER_UPDATE_SEGMENT_VIEW_H_
