#ifndef SINEW_LEARNER_TRAINER_REPLAY_NEED_H_
#define SINEW_LEARNER_TRAINER_REPLAY_NEED_H_

#include <cstdint>

#include "absl/status/status.h"
#include "proto/sinew/v1/recipe.pb.h"
#include "proto/sinew/v1/rollout.pb.h"

namespace sinew::learner {

// Bytes that a run's replay must be able to hold, lest it ever waits for room
// that nobody makes: those of a training iteration and of the evaluation that
// is taken with it, each segment as large as it may be
// (common/segment/segment_size.h). There is one evaluation at a time, since
// evaluation.delay <= evaluation.interval.
//
// `recipe`: defaults filled, valid; `evaluation_starts`: of one evaluation,
// >= 0. Pure; thread-safe; never blocks.
int64_t ReplayBytesNeeded(const v1::Recipe& recipe,
                          const v1::SegmentLayout& layout,
                          int64_t evaluation_starts);

// INVALID_ARGUMENT, naming the fields, if that is more than `limit_bytes`.
absl::Status CheckReplayHolds(const v1::Recipe& recipe,
                              const v1::SegmentLayout& layout,
                              int64_t evaluation_starts, int64_t limit_bytes);

}  // namespace sinew::learner

#endif  // SINEW_LEARNER_TRAINER_REPLAY_NEED_H_
