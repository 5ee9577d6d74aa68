#ifndef SINEW_REPLAY_VALIDATE_H_
#define SINEW_REPLAY_VALIDATE_H_

#include <cstdint>
#include <memory>
#include <string>

#include "absl/status/status.h"
#include "absl/strings/string_view.h"
#include "proto/sinew/v1/replay.pb.h"
#include "proto/sinew/v1/rollout.pb.h"
#include "proto/sinew/v1/state_limits.pb.h"

namespace sinew::replay {

// What one order's segment must be.
struct Expectation {
  std::string run_id;
  v1::OpenRequest::Expected expected;
  // Null if no columns are checked (expected.steps is 0).
  std::shared_ptr<const v1::SegmentLayout> layout;
  // Null: neither sizes nor upper bounds of states, episodes, rows and results
  // are checked.
  std::shared_ptr<const v1::StateLimits> limits;
};

// Pure functions; thread-safe; never block.

// Whether an expectation can be met at all: INVALID_ARGUMENT names the field.
absl::Status CheckExpectation(const Expectation& expectation);

// Bytes that a valid segment has at most, serialised
// (common/segment/segment_size.h), of an expectation that CheckExpectation has
// passed.
int64_t MaxSegmentBytes(const Expectation& expectation);

// Judges a serialised segment: VERDICT_ACCEPTED and `segment` filled, or the
// reason why not, with expected and found. Total: any bytes get a verdict.
v1::PutSegmentResponse Judge(const Expectation& expectation,
                             absl::string_view bytes, v1::Segment& segment);

// A refusal.
v1::PutSegmentResponse Refuse(int64_t order_id,
                              v1::PutSegmentResponse::Verdict verdict,
                              absl::string_view detail);

}  // namespace sinew::replay

#endif  // SINEW_REPLAY_VALIDATE_H_
