#ifndef SINEW_LEARNER_DISTILLATION_LABELLER_H_
#define SINEW_LEARNER_DISTILLATION_LABELLER_H_

#include <cstdint>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/types/span.h"
#include "learner/distillation/labels.h"
#include "learner/learner.h"
#include "learner/update/normaliser.h"
#include "learner/update/rank_pool.h"
#include "proto/sinew/v1/rollout.pb.h"
#include "teacher/client/annotator.h"

namespace sinew::learner {

// One segment, labelled.
struct LabelledSegment {
  StateChunk chunk;
  Moments moments;  // of its NormaliserRows (labels.h)
};

// Labels segments ahead of the update that learns from them:
//
//   Prepare(segments)   asks the teacher, makes chunks, keeps them; these are
//                       all training segments of one iteration, by order_id
//   Take(segments)      hands them over, if they are of these segments' orders
//                       (segments are functions of those); else prepares first
//
// Thread-safety: one caller. Ownership: owns what is prepared; borrows teacher
// and pool. Blocking: as the annotator; then computes. Errors: those of
// labels.h, and INVALID_ARGUMENT for no segments: nothing is prepared then.
class Labeller {
 public:
  Labeller(LabelOptions options, teacher::Annotator& annotator, RankPool& pool)
      : options_(std::move(options)), annotator_(annotator), pool_(pool) {}

  absl::Status Prepare(absl::Span<const v1::Segment* const> segments);
  absl::StatusOr<std::vector<LabelledSegment>> Take(
      absl::Span<const v1::Segment* const> segments);
  void Forget() { prepared_.clear(); }

  const LabelOptions& options() const { return options_; }

 private:
  // All valid rows in one call, which the annotator divides as it sees fit.
  // `normaliser_rows`: NormaliserRows of each segment.
  absl::StatusOr<std::vector<LabelledSegment>> Label(
      absl::Span<const v1::Segment* const> segments,
      absl::Span<const SegmentView> views,
      absl::Span<const std::vector<uint8_t>> normaliser_rows);

  const LabelOptions options_;
  teacher::Annotator& annotator_;
  RankPool& pool_;
  std::vector<int64_t> prepared_for_;  // orders
  std::vector<LabelledSegment> prepared_;
};

// What there is to say of labelled segments: samples, and means over their
// valid rows, those of episodes in which teacher or prior act
// (Distillation.teacher_share, prior_share) among them. Precondition: they
// passed ViewForLabels.
UpdateStatistics DescribeRows(absl::Span<const v1::Segment* const> segments,
                              const LabelOptions& options);

}  // namespace sinew::learner

#endif  // SINEW_LEARNER_DISTILLATION_LABELLER_H_
