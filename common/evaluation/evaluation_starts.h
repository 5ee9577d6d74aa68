#ifndef SINEW_COMMON_EVALUATION_EVALUATION_STARTS_H_
#define SINEW_COMMON_EVALUATION_EVALUATION_STARTS_H_

#include <vector>

#include "absl/status/statusor.h"
#include "proto/sinew/v1/motion.pb.h"
#include "proto/sinew/v1/rollout.pb.h"

namespace sinew {

// Where evaluations of a library begin and how long each must be survived, in
// clip order, `starts` per clip, evenly spaced in phase:
//   looping clips   start k at frame floor(k n / starts) of n, for `seconds`;
//   others          start k at frame floor(k h / starts), h = ceil(last / 2),
//                   until the last frame.
// Pure. INVALID_ARGUMENT unless starts >= 1 and seconds covers a frame.
absl::StatusOr<std::vector<v1::EvaluationStart>> MakeEvaluationStarts(
    const v1::MotionLibrary& library, int starts, double seconds);

}  // namespace sinew

#endif  // SINEW_COMMON_EVALUATION_EVALUATION_STARTS_H_
