#include "sim/world/termination.h"

#include <algorithm>

namespace sinew::world {

BodyDistances MeasureDistances(const BodyState& body,
                               const BodyState& reference,
                               absl::Span<const int> terminating) {
  BodyDistances distances;
  for (size_t b = 0; b < body.position.size(); ++b) {
    distances.mean += (reference.position[b] - body.position[b]).norm();
  }
  distances.mean /= static_cast<double>(body.position.size());
  for (int b : terminating) {
    distances.max_terminating =
        std::max(distances.max_terminating,
                 (reference.position[b] - body.position[b]).norm());
  }
  return distances;
}

EpisodeEnding JudgeEpisode(double max_terminating_distance,
                           double max_body_distance, int64_t start_frame,
                           int32_t steps, int64_t last_frame,
                           int32_t max_episode_steps) {
  EpisodeEnding ending;
  ending.terminated =
      steps > 1 && !(max_terminating_distance <= max_body_distance);
  ending.clip_end = !ending.terminated && start_frame + steps >= last_frame;
  ending.time_limit =
      !ending.terminated && !ending.clip_end && steps >= max_episode_steps;
  return ending;
}

}  // namespace sinew::world
