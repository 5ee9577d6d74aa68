#ifndef SINEW_COMMON_SEGMENT_ROW_EPISODES_H_
#define SINEW_COMMON_SEGMENT_ROW_EPISODES_H_

#include <cstdint>
#include <vector>

#include "absl/status/statusor.h"
#include "proto/sinew/v1/rollout.pb.h"

namespace sinew {

// The episode of every row [T, E] of a training segment: its number among those
// of its environment, as in EnvironmentState. Counted back from end_states over
// the rows that ended one.
//
// Pure; never blocks. Precondition: the segment's columns passed CheckColumns
// (segment_layout.h). INVALID_ARGUMENT names end_states if there is not one for
// every environment, or if an episode's number is less than that of the
// episodes that ended in its environment's rows.
absl::StatusOr<std::vector<int64_t>> EpisodesOfRows(const v1::Segment& segment);

}  // namespace sinew

#endif  // SINEW_COMMON_SEGMENT_ROW_EPISODES_H_
