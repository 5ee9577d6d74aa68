#ifndef SINEW_ACTOR_SEGMENT_WRITER_H_
#define SINEW_ACTOR_SEGMENT_WRITER_H_

#include <cstdint>
#include <vector>

#include "absl/types/span.h"
#include "common/segment/segment_layout.h"
#include "proto/sinew/v1/rollout.pb.h"
#include "sim/world/tracking_task.h"

namespace sinew::actor {

// One step as it is written into a segment; shapes as in the layout.
struct StepRow {
  absl::Span<const float> observation;
  absl::Span<const float> action;
  absl::Span<const float> action_mean;
  absl::Span<const double> target;
  // Unused unless the layout has them.
  absl::Span<const double> base, teacher_base;
  absl::Span<const float> latent_noise;
  double log_probability = 0;
  int32_t clip = 0;
  int32_t frame = 0;
  const world::StepResult* result = nullptr;
};

// Fills the columns of a training segment. Rows come in order of step, then
// environment; all T * E steps and E boundaries must be written.
//
// Thread-safety: one caller. Ownership: borrows the segment until Finish.
// Blocking: never. The columns of steps are allocated by the constructor;
// WriteTruncation allocates as it grows. Errors: none.
class SegmentWriter {
 public:
  SegmentWriter(const v1::SegmentLayout& layout, int steps, int environments,
                v1::Segment* segment);

  void WriteStep(int step, int environment, const StepRow& row);
  // Observation of the state that the (truncated) step led to.
  void WriteTruncation(int step, int environment,
                       absl::Span<const float> observation);
  void WriteBoundary(int environment, absl::Span<const float> observation);

  // Sets the number of truncation rows.
  void Finish();

 private:
  v1::Tensor* Column(absl::string_view name) const;

  v1::Segment* segment_;
  int environments_;
  int32_t truncations_ = 0;
  // Where the columns of steps begin.
  char *observation_, *action_, *action_mean_, *target_, *log_probability_,
      *reward_, *reward_terms_, *body_distance_, *terminated_, *truncated_,
      *valid_, *clip_, *frame_, *boundary_;
  // Null: the layout has none.
  char *base_ = nullptr, *teacher_base_ = nullptr, *latent_noise_ = nullptr;
};

}  // namespace sinew::actor

#endif  // SINEW_ACTOR_SEGMENT_WRITER_H_
