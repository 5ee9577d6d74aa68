#ifndef SINEW_ACTOR_ORDER_CHECK_H_
#define SINEW_ACTOR_ORDER_CHECK_H_

#include "absl/status/status.h"
#include "actor/prepared_snapshot.h"
#include "actor/rollout_assets.h"
#include "proto/sinew/v1/rollout.pb.h"

namespace sinew::actor {

// Whether an order can be run with this snapshot, these assets and a worker of
// `max_environments`: kind, layout, snapshot version and digest, sizes,
// evaluation starts. (States are checked as they are loaded: environment.h.)
// INVALID_ARGUMENT names order, field, expected and found. Pure.
absl::Status CheckOrder(const v1::Order& order,
                        const PreparedSnapshot& snapshot,
                        const RolloutAssets& assets, int max_environments);

}  // namespace sinew::actor

#endif  // SINEW_ACTOR_ORDER_CHECK_H_
