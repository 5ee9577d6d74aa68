#ifndef SINEW_TOOLS_BENCH_RAW_PHYSICS_H_
#define SINEW_TOOLS_BENCH_RAW_PHYSICS_H_

#include <mujoco/mujoco.h>

#include <cstdint>
#include <vector>

#include "absl/status/status.h"
#include "absl/types/span.h"
#include "proto/sinew/v1/rollout.pb.h"
#include "sim/world/tracking_task.h"

namespace sinew::bench {

// The physics of a training segment and nothing else: of every environment that
// the order handed over with a state, the steps up to the end of its episode or
// of the segment, as applied forces per mj_step, worked out beforehand.
//
// Use: Prepare, then Run as often as wanted.
//
// Thread-safety: one caller. Ownership: borrows the task; owns its mjData.
// Blocking: both compute. Errors: Prepare gives INTERNAL if the forces do not
// lead to the segment's end states, bit for bit.
class RawPhysics {
 public:
  explicit RawPhysics(const world::TrackingTask& task);

  absl::Status Prepare(const v1::Order& order, const v1::Segment& segment);

  // Plain loops around mj_step; returns how many.
  int64_t Run();

 private:
  // One environment.
  struct Track {
    std::vector<double> start;   // physics row
    std::vector<double> forces;  // [steps, nv] of qfrc_applied
  };
  Track Record(const v1::EnvironmentState& state, int steps, int environment,
               int environments, absl::Span<const double> targets);

  const world::TrackingTask& task_;
  const mjModel* const model_;
  const character::DataPtr data_;
  std::vector<Track> tracks_;
};

}  // namespace sinew::bench

#endif  // SINEW_TOOLS_BENCH_RAW_PHYSICS_H_
