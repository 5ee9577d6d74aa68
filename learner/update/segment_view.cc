#include "learner/update/segment_view.h"

#include <string>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/string_view.h"
#include "common/segment/segment_layout.h"

namespace sinew::learner {
namespace {

// A column that CheckColumns has passed. Protobuf's strings are aligned for
// any number.
template <typename T>
absl::Span<const T> Column(const v1::Segment& segment, absl::string_view name) {
  const std::string& data = FindColumn(segment, name)->data();
  return {reinterpret_cast<const T*>(data.data()), data.size() / sizeof(T)};
}

absl::Status AtOrder(const v1::Segment& segment, const absl::Status& status) {
  if (status.ok()) return status;
  return absl::Status(status.code(), absl::StrCat("order ", segment.order_id(),
                                                  ": ", status.message()));
}

}  // namespace

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
  view.observation = Column<float>(segment, column::kObservation);
  view.action = Column<float>(segment, column::kAction);
  view.action_mean = Column<float>(segment, column::kActionMean);
  view.log_probability = Column<float>(segment, column::kLogProbability);
  view.reward = Column<float>(segment, column::kReward);
  view.reward_terms = Column<float>(segment, column::kRewardTerms);
  view.body_distance = Column<float>(segment, column::kBodyDistance);
  view.terminated = Column<uint8_t>(segment, column::kTerminated);
  view.truncated = Column<uint8_t>(segment, column::kTruncated);
  view.valid = Column<uint8_t>(segment, column::kValid);
  view.boundary_observation =
      Column<float>(segment, column::kBoundaryObservation);
  view.truncation_index = Column<int32_t>(segment, column::kTruncationIndex);
  view.truncation_observation =
      Column<float>(segment, column::kTruncationObservation);
  return view;
}

}  // namespace sinew::learner
