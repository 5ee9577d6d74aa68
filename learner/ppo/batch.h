#ifndef SINEW_LEARNER_PPO_BATCH_H_
#define SINEW_LEARNER_PPO_BATCH_H_

#include <cstdint>
#include <vector>

#include "absl/status/status.h"
#include "absl/types/span.h"
#include "learner/update/segment_view.h"
#include "proto/sinew/v1/rollout.pb.h"

namespace sinew::learner {

// Means over the valid rows of a batch.
struct BatchFigures {
  int64_t valid_rows = 0;
  double reward_mean = 0;
  std::vector<double> reward_terms;
  double body_distance_mean_m = 0;
  double explained_variance = 0;  // of the returns, by the values before
};

// The rows of one iteration, in columns: segments in the given order, each
// [T, E] row-major. N rows in all; behind them stand B bootstrap rows, of which
// only observation and value exist: per segment those of boundary_observation,
// then those of truncation_observation.
//
//   Reset                                   sizes; views of the segments
//   per segment, on any thread: CopyColumns
//   the caller fills values() [N + B]
//   per segment, on any thread: ComputeReturns
//   Finish                                  advantages normalised, figures
//
// Thread-safety: per-segment methods on different segments at once; the rest
//   alone. Ownership: keeps its memory between batches; views the segments
//   until the next Reset. Blocking: never. Errors: Reset, as ViewSegment.
class Batch {
 public:
  // `action_width` A and the layout that segments must have; discount and
  // lambda of ComputeGae. Networks predict (1 - discount) times the discounted
  // sum of rewards, about the size of one reward: so are values() when the
  // caller fills them, and value_target().
  Batch(int64_t action_width, v1::SegmentLayout layout, double discount,
        double lambda);

  // A block of observations that belongs to consecutive rows.
  struct Block {
    int64_t first_row = 0;
    absl::Span<const float> observations;  // [rows, O]
    // [rows, Z]; empty: the layout has none, or these are bootstrap rows.
    absl::Span<const float> latent_noise = {};
  };

  // The last `images` of the segments are mirror images of what acted
  // (ppo.mirror): learned from like the others, but not `acted`.
  absl::Status Reset(absl::Span<const v1::Segment* const> segments,
                     int64_t images = 0);
  void CopyColumns(int segment);
  void ComputeReturns(int segment);
  // Advantages get mean 0 and standard deviation 1 over the valid rows.
  BatchFigures Finish();

  int num_segments() const { return static_cast<int>(views_.size()); }
  const SegmentView& view(int segment) const { return views_[segment]; }
  // Rows, boundary and truncations of a segment (the last may be empty).
  std::vector<Block> Blocks(int segment) const;

  int64_t rows() const { return rows_; }                      // N
  int64_t bootstrap_rows() const { return bootstrap_rows_; }  // B

  absl::Span<float> values() { return absl::MakeSpan(values_); }
  absl::Span<const float> action() const { return action_; }  // [N, A]
  absl::Span<const float> action_mean() const { return action_mean_; }
  absl::Span<const float> log_probability() const { return log_probability_; }
  absl::Span<const float> advantage() const { return advantage_; }
  absl::Span<const float> value_target() const { return value_target_; }
  // 1 where the row is valid, 0 where it must have no effect.
  absl::Span<const float> weight() const { return weight_; }
  // 1 where the row is valid and its action one that the policy took, so that
  // action_mean is the policy's of then; 0 in images, where it is that of the
  // other side.
  absl::Span<const float> acted() const { return acted_; }

 private:
  // Before advantages are normalised.
  double ExplainedVariance(int64_t valid_rows) const;

  const int64_t action_width_;
  const v1::SegmentLayout layout_;
  const double discount_;
  const double lambda_;
  std::vector<SegmentView> views_;
  std::vector<int64_t> first_row_;        // of each segment
  std::vector<int64_t> first_bootstrap_;  // likewise, counted from 0
  int64_t first_image_ = 0;               // segment
  int64_t rows_ = 0;
  int64_t bootstrap_rows_ = 0;
  std::vector<float> values_;  // [N + B]
  std::vector<float> next_values_;
  std::vector<float> action_, action_mean_;  // [N, A]
  std::vector<float> log_probability_, advantage_, value_target_;
  std::vector<float> weight_, acted_;
};

}  // namespace sinew::learner

#endif  // SINEW_LEARNER_PPO_BATCH_H_
