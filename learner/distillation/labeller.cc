#include "learner/distillation/labeller.h"

#include <algorithm>
#include <utility>

#include "common/segment/segment_layout.h"
#include "common/status_macros.h"
#include "learner/memory/memory_chunk.h"
#include "learner/update/segment_view.h"

namespace sinew::learner {
namespace {

std::vector<int64_t> OrdersOf(absl::Span<const v1::Segment* const> segments) {
  std::vector<int64_t> orders;
  for (const v1::Segment* segment : segments) {
    orders.push_back(segment->order_id());
  }
  return orders;
}

// Each segment's part of all targets.
std::vector<absl::Span<const double>> Divide(
    absl::Span<const double> targets, absl::Span<const SegmentView> views,
    int64_t actions) {
  std::vector<absl::Span<const double>> parts;
  for (const SegmentView& view : views) {
    const size_t size = CountValid(view) * actions;
    parts.push_back(targets.subspan(0, size));
    targets.remove_prefix(size);
  }
  return parts;
}

}  // namespace

absl::Status Labeller::Prepare(absl::Span<const v1::Segment* const> segments) {
  prepared_.clear();
  if (segments.empty()) {
    return absl::InvalidArgumentError("segments: expected some, found none");
  }
  std::vector<SegmentView> views;
  std::vector<std::vector<uint8_t>> normaliser_rows;
  int64_t environments = 0;
  for (const v1::Segment* segment : segments) {
    SINEW_ASSIGN_OR_RETURN(const SegmentView view,
                           ViewForLabels(*segment, options_));
    SINEW_ASSIGN_OR_RETURN(
        std::vector<uint8_t> rows,
        NormaliserRows(*segment, view, environments, options_));
    environments += view.environments;
    views.push_back(view);
    normaliser_rows.push_back(std::move(rows));
  }
  SINEW_ASSIGN_OR_RETURN(prepared_, Label(segments, views, normaliser_rows));
  prepared_for_ = OrdersOf(segments);
  return absl::OkStatus();
}

absl::StatusOr<std::vector<LabelledSegment>> Labeller::Take(
    absl::Span<const v1::Segment* const> segments) {
  if (prepared_.empty() || prepared_for_ != OrdersOf(segments)) {
    SINEW_RETURN_IF_ERROR(Prepare(segments));
  }
  return std::exchange(prepared_, {});
}

absl::StatusOr<std::vector<LabelledSegment>> Labeller::Label(
    absl::Span<const v1::Segment* const> segments,
    absl::Span<const SegmentView> views,
    absl::Span<const std::vector<uint8_t>> normaliser_rows) {
  SINEW_ASSIGN_OR_RETURN(const std::vector<double> targets,
                         AskTargets(segments, views, options_, annotator_));
  const SequenceShape& shape = options_.shape;
  const auto parts = Divide(targets, views, shape.action);
  std::vector<LabelledSegment> labelled(segments.size());
  SINEW_RETURN_IF_ERROR(pool_.TryRun(
      static_cast<int>(segments.size()), [&](int i) -> absl::Status {
        SINEW_ASSIGN_OR_RETURN(
            const LabelledSequences sequences,
            LabelSegment(*segments[i], views[i], options_, parts[i]));
        labelled[i].chunk = MakeChunk(sequences, shape);
        labelled[i].moments = Moments(shape.observation);
        ComputeMoments(views[i].observation, normaliser_rows[i],
                       labelled[i].moments);
        return absl::OkStatus();
      }));
  return labelled;
}

UpdateStatistics DescribeRows(absl::Span<const v1::Segment* const> segments,
                              const LabelOptions& options) {
  UpdateStatistics statistics;
  statistics.reward_terms.resize(kNumRewardTerms);
  for (const v1::Segment* segment : segments) {
    const SegmentView view = *ViewSegment(*segment, options.layout);
    for (int64_t i = 0; i < view.rows(); ++i) {
      if (view.valid[i] == 0) continue;
      ++statistics.samples;
      statistics.reward_mean += view.reward[i];
      statistics.body_distance_mean_m += view.body_distance[i];
      for (int k = 0; k < kNumRewardTerms; ++k) {
        statistics.reward_terms[k] +=
            view.reward_terms[i * kNumRewardTerms + k];
      }
    }
  }
  const double count =
      static_cast<double>(std::max<int64_t>(1, statistics.samples));
  statistics.reward_mean /= count;
  statistics.body_distance_mean_m /= count;
  for (double& term : statistics.reward_terms) term /= count;
  return statistics;
}

}  // namespace sinew::learner
