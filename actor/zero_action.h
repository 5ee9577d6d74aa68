#ifndef SINEW_ACTOR_ZERO_ACTION_H_
#define SINEW_ACTOR_ZERO_ACTION_H_

#include <cstdint>

#include "absl/status/statusor.h"
#include "proto/sinew/v1/snapshot.pb.h"

namespace sinew::actor {

// A snapshot whose policy has mean action zero for every observation, with the
// graph that all tracking policies have: the baseline of evaluations, and the
// start of untrained training. `std`: standard deviation of sampled actions in
// units of action, > 0 (evaluations do not sample). Pure. INVALID_ARGUMENT for
// widths or std out of range.
absl::StatusOr<v1::Snapshot> ZeroActionSnapshot(int64_t observation_width,
                                                int64_t action_width,
                                                double std = 0.4);

}  // namespace sinew::actor

#endif  // SINEW_ACTOR_ZERO_ACTION_H_
