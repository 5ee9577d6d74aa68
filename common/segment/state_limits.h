#ifndef SINEW_COMMON_SEGMENT_STATE_LIMITS_H_
#define SINEW_COMMON_SEGMENT_STATE_LIMITS_H_

#include <cstdint>

#include "absl/status/status.h"
#include "proto/sinew/v1/rollout.pb.h"
#include "proto/sinew/v1/state_limits.pb.h"

namespace sinew {

// What every role that is handed states of environments asks of them: replay
// before it keeps a segment, an actor before it takes up an order. Pure
// functions; thread-safe; never block.

// Whether the limits themselves make sense: INVALID_ARGUMENT names the field.
absl::Status CheckLimits(const v1::StateLimits& limits);

// Whether such a run's rollout may go on from `state`: INVALID_ARGUMENT names
// the field of the state, what was expected and what was found. Nothing but
// `episode` is looked at where `physics` is empty.
absl::Status CheckState(const v1::EnvironmentState& state,
                        const v1::StateLimits& limits);

// Whether an episode of such a run may have begun there: INVALID_ARGUMENT, as
// above ("clip" or "start_frame").
absl::Status CheckPlace(int64_t clip, int64_t start_frame,
                        const v1::StateLimits& limits);

}  // namespace sinew

#endif  // SINEW_COMMON_SEGMENT_STATE_LIMITS_H_
