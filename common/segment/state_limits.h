#ifndef SINEW_COMMON_SEGMENT_STATE_LIMITS_H_
#define SINEW_COMMON_SEGMENT_STATE_LIMITS_H_

#include <cstdint>

#include "absl/status/status.h"
#include "proto/sinew/v1/rollout.pb.h"
#include "proto/sinew/v1/state_limits.pb.h"

namespace sinew {

// What every role that is handed states of environments asks of them: replay
// before it keeps a segment, an actor before it takes up an order. Pure
// functions; thread-safe; never block. Errors: INVALID_ARGUMENT naming the
// field, what was expected and what was found. All but CheckLimits want limits
// that it has passed.

// Whether the limits themselves make sense.
absl::Status CheckLimits(const v1::StateLimits& limits);

// Whether such a run's rollout may go on from `state`. Nothing but `episode` is
// looked at where `physics` is empty.
absl::Status CheckState(const v1::EnvironmentState& state,
                        const v1::StateLimits& limits);

// Whether an episode of such a run may have begun there ("clip" or
// "start_frame").
absl::Status CheckPlace(int32_t clip, int32_t start_frame,
                        const v1::StateLimits& limits);

// Whether an episode of such a run may have ended so: its place and its steps.
absl::Status CheckEpisode(const v1::EpisodeEnd& episode,
                          const v1::StateLimits& limits);

// All of a segment: end states, episodes, the clips of its rows, and the places
// of results and of what their bodies were carried to ("end_states[1].step").
absl::Status CheckSegment(const v1::Segment& segment,
                          const v1::StateLimits& limits);

}  // namespace sinew

#endif  // SINEW_COMMON_SEGMENT_STATE_LIMITS_H_
