#ifndef SINEW_COMMON_SEGMENT_SEGMENT_SIZE_H_
#define SINEW_COMMON_SEGMENT_SEGMENT_SIZE_H_

#include <cstdint>

#include "proto/sinew/v1/rollout.pb.h"

namespace sinew {

// Bytes that a valid segment has at most, serialised. By it replay refuses what
// is larger, and a learner knows whether a replay can hold what it will ask
// for. Pure functions; thread-safe; never block. Sizes beyond 2^62 are that.

// Of a training order: every column full, all steps truncated, generous room
// for states and episodes. `environments` >= 1, `steps` >= 1.
int64_t MaxTrainingBytes(const v1::SegmentLayout& layout, int64_t environments,
                         int64_t steps);

// Of an evaluation's order: results alone. `starts` >= 1.
int64_t MaxEvaluationBytes(int64_t starts);

}  // namespace sinew

#endif  // SINEW_COMMON_SEGMENT_SEGMENT_SIZE_H_
