#ifndef SINEW_ACTOR_TESTING_ORDER_ALLOCATIONS_H_
#define SINEW_ACTOR_TESTING_ORDER_ALLOCATIONS_H_

#include <cstdint>

#include "actor/testing/rollout_rig.h"
#include "proto/sinew/v1/rollout.pb.h"

namespace sinew::actor::testing {

// Allocations of an environment's order of so many steps, the second time that
// it is run; no episode may end in it (StandingOrder), which is expected.
int64_t OrderAllocations(RolloutRig& rig, int horizon);

}  // namespace sinew::actor::testing

#endif  // SINEW_ACTOR_TESTING_ORDER_ALLOCATIONS_H_
