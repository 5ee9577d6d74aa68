#include "learner/update/segment_view.h"

#include "absl/strings/str_cat.h"

namespace sinew::learner {

absl::Status AtOrder(const v1::Segment& segment, const absl::Status& status) {
  if (status.ok()) return status;
  return absl::Status(status.code(), absl::StrCat("order ", segment.order_id(),
                                                  ": ", status.message()));
}

absl::StatusOr<SegmentView> ViewSegment(const v1::Segment& segment,
                                        const v1::SegmentLayout& layout) {
  const v1::Tensor* reward = FindColumn(segment, column::kReward);
  if (reward == nullptr || reward->shape_size() != 2 || reward->shape(0) < 1 ||
      reward->shape(1) < 1) {
    return absl::InvalidArgumentError(
        absl::StrCat("order ", segment.order_id(),
                     ": segment column reward: expected shape [T, E], found ",
                     reward == nullptr ? "no such column" : "another"));
  }
  SegmentView view;
  view.steps = reward->shape(0);
  view.environments = reward->shape(1);
  const absl::Status fits = AtOrder(
      segment, CheckColumns(segment, layout, view.steps, view.environments));
  if (!fits.ok()) return fits;
  view.observation = ColumnOf<float>(segment, column::kObservation);
  view.action = ColumnOf<float>(segment, column::kAction);
  view.action_mean = ColumnOf<float>(segment, column::kActionMean);
  view.log_probability = ColumnOf<float>(segment, column::kLogProbability);
  if (FindColumn(segment, column::kLatentNoise) != nullptr) {
    view.latent_noise = ColumnOf<float>(segment, column::kLatentNoise);
  }
  view.reward = ColumnOf<float>(segment, column::kReward);
  view.reward_terms = ColumnOf<float>(segment, column::kRewardTerms);
  view.body_distance = ColumnOf<float>(segment, column::kBodyDistance);
  view.terminated = ColumnOf<uint8_t>(segment, column::kTerminated);
  view.truncated = ColumnOf<uint8_t>(segment, column::kTruncated);
  view.valid = ColumnOf<uint8_t>(segment, column::kValid);
  view.boundary_observation =
      ColumnOf<float>(segment, column::kBoundaryObservation);
  view.truncation_index = ColumnOf<int32_t>(segment, column::kTruncationIndex);
  view.truncation_observation =
      ColumnOf<float>(segment, column::kTruncationObservation);
  return view;
}

}  // namespace sinew::learner
