#ifndef SINEW_TOOLS_BENCH_ACTOR_MEMORY_H_
#define SINEW_TOOLS_BENCH_ACTOR_MEMORY_H_

#include <memory>

#include "absl/status/statusor.h"
#include "actor/rollout_assets.h"
#include "proto/sinew/v1/snapshot.pb.h"

namespace sinew::bench {

// What a worker with so many environments adds to the resident memory of this
// process, its first order's segment included.
struct MemoryFigures {
  int environments = 0;
  double actor_mb = 0;            // 1e6 bytes
  double per_environment_kb = 0;  // 1e3 bytes
};

// Makes a worker, runs one order on it and compares
// the process before and after. Meant for a process in which little has been
// freed before.
//
// Blocking: a second or two. Errors: those of RolloutWorker; NOT_FOUND where
// the system does not tell.
absl::StatusOr<MemoryFigures> MeasureMemory(
    int environments, int horizon,
    const std::shared_ptr<const actor::RolloutAssets>& assets,
    const v1::Snapshot& snapshot);

}  // namespace sinew::bench

#endif  // SINEW_TOOLS_BENCH_ACTOR_MEMORY_H_
