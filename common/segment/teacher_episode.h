#ifndef SINEW_COMMON_SEGMENT_TEACHER_EPISODE_H_
#define SINEW_COMMON_SEGMENT_TEACHER_EPISODE_H_

#include <cstdint>

#include "common/random/philox.h"

namespace sinew {

// Whether the teacher acts in an episode (Distillation.teacher_share): drawn
// once for each, of seed (Order.seed), environment and episode alone. So
// whoever reads a segment knows who acted in it, and what a start table counts
// of the student.
//
// Pure; never blocks; no errors.
inline bool IsTeacherEpisode(uint64_t seed, uint64_t environment,
                             uint64_t episode, double share) {
  return share > 0 && Uniform({.seed = seed,
                               .environment = environment,
                               .episode = episode,
                               .purpose = RandomPurpose::kTeacher}) < share;
}

}  // namespace sinew

#endif  // SINEW_COMMON_SEGMENT_TEACHER_EPISODE_H_
