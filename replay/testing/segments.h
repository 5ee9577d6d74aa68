#ifndef SINEW_REPLAY_TESTING_SEGMENTS_H_
#define SINEW_REPLAY_TESTING_SEGMENTS_H_

#include <cstdint>
#include <string>

#include "absl/strings/string_view.h"
#include "absl/types/span.h"
#include "proto/sinew/v1/replay.pb.h"
#include "proto/sinew/v1/rollout.pb.h"
#include "replay/validate.h"

namespace sinew::replay {

// A run whose orders have 2 environments, 3 steps, observations of 4 numbers
// and actions of 2; snapshot and iteration follow from the order's id.
inline constexpr char kRun[] = "run";
inline constexpr int kEnvironments = 2;
inline constexpr int kSteps = 3;

v1::SegmentLayout TestLayout();

// What the learner says of an order.
v1::OpenRequest::Expected MakeExpected(int64_t order_id, int64_t iteration = 0);
Expectation MakeExpectation(int64_t order_id);
v1::OpenRequest MakeOpen(absl::Span<const int64_t> order_ids,
                         int64_t iteration = 0, bool reset = false);

// A valid segment of that order; numbers differ from order to order.
v1::Segment MakeSegment(int64_t order_id, int64_t iteration = 0);
std::string MakeSegmentBytes(int64_t order_id, int64_t iteration = 0);

// The column of that name, to change it; it must be there.
v1::Tensor& Column(v1::Segment& segment, absl::string_view name);

}  // namespace sinew::replay

#endif  // SINEW_REPLAY_TESTING_SEGMENTS_H_
