#ifndef SINEW_SIM_WORLD_TERMINATION_H_
#define SINEW_SIM_WORLD_TERMINATION_H_

#include <cstdint>

#include "absl/types/span.h"
#include "sim/world/body_state.h"

namespace sinew::world {

// How far a body is from its reference: distances between frame origins, m.
struct BodyDistances {
  double mean = 0;             // over all tracked bodies
  double max_terminating = 0;  // over those that may end an episode; 0 if none
};

// `terminating` are indices into the tracked bodies. Pure; does not allocate.
BodyDistances MeasureDistances(const BodyState& body,
                               const BodyState& reference,
                               absl::Span<const int> terminating);

// How an episode stands after a step. At most one is true.
struct EpisodeEnding {
  bool terminated = false;  // failed: the value of the state is 0
  bool time_limit = false;  // truncated: max_episode_steps are done
  bool clip_end = false;    // truncated: the reference has no further frame
};

// Failure comes before truncation and clip end before time limit:
//   terminated   a terminating body is farther than max_body_distance off
//                (or the distance is NaN), and this is not the first step: a
//                start that is off (noise) gets one step to answer
//   clip_end     frame start_frame + steps is the clip's last
//   time_limit   steps >= max_episode_steps
// `steps` counts the step just done, >= 1. `last_frame` is
// motion::LastFrame(clip).
EpisodeEnding JudgeEpisode(double max_terminating_distance,
                           double max_body_distance, int64_t start_frame,
                           int32_t steps, int64_t last_frame,
                           int32_t max_episode_steps);

}  // namespace sinew::world

#endif  // SINEW_SIM_WORLD_TERMINATION_H_
