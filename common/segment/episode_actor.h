#ifndef SINEW_COMMON_SEGMENT_EPISODE_ACTOR_H_
#define SINEW_COMMON_SEGMENT_EPISODE_ACTOR_H_

#include <cstdint>

#include "common/random/philox.h"
#include "proto/sinew/v1/distillation.pb.h"

namespace sinew {

// Who chooses the actions of an episode.
enum class EpisodeActor {
  kPolicy,   // graph "policy": the student, where the recipe distils
  kTeacher,  // graph "teacher" (Distillation.teacher_share)
  kPrior,    // graph "sample" (Distillation.prior_share)
};

// Drawn once for each episode, of seed (Order.seed), environment and episode
// alone. So whoever reads a segment knows who acted in it, what a start
// table counts of the student, and what its normaliser does. A recipe without
// distillation has the default message: the policy.
//
// Pure; never blocks; no errors. Precondition: environment, episode >= 0.
inline EpisodeActor WhoActs(const v1::Distillation& distillation, uint64_t seed,
                            int64_t environment, int64_t episode) {
  const double teacher = distillation.teacher_share();
  const double prior = episode < distillation.prior_first_episode()
                           ? 0
                           : distillation.prior_share();
  const double others = teacher + prior;
  if (!(others > 0)) return EpisodeActor::kPolicy;
  const double drawn =
      Uniform({.seed = seed,
               .environment = static_cast<uint64_t>(environment),
               .episode = static_cast<uint64_t>(episode),
               .purpose = RandomPurpose::kTeacher});
  if (drawn < teacher) return EpisodeActor::kTeacher;
  return drawn < others ? EpisodeActor::kPrior : EpisodeActor::kPolicy;
}

}  // namespace sinew

#endif  // SINEW_COMMON_SEGMENT_EPISODE_ACTOR_H_
