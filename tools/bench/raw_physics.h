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

// The physics of rollouts and nothing else, as applied forces per mj_step that
// are worked out beforehand. Fed with a rollout in orders of one control step
// each, it holds every step but the first of each episode.
//
// Use: Clear, Add one order after another, then Run as often as wanted.
//
// Thread-safety: one caller. Ownership: borrows the task; owns its mjData.
// Blocking: both compute. Errors: Add gives INTERNAL if the forces do not lead
// to the segment's end states, bit for bit.
class RawPhysics {
 public:
  explicit RawPhysics(const world::TrackingTask& task);

  void Clear();

  // Of each environment that the order hands over with a state, its one step.
  absl::Status Add(const v1::Order& order, const v1::Segment& segment);

  // Plain loops around mj_step; returns how many.
  int64_t Run();

 private:
  // One stretch of an episode.
  struct Track {
    std::vector<double> start;   // physics row
    std::vector<double> forces;  // [steps, nv] of qfrc_applied
  };
  void Record(const v1::EnvironmentState& state,
              absl::Span<const double> target, Track* track);

  const world::TrackingTask& task_;
  const mjModel* const model_;
  const character::DataPtr data_;
  std::vector<Track> tracks_;
  std::vector<int> open_;  // by environment: its track; -1: none
};

}  // namespace sinew::bench

#endif  // SINEW_TOOLS_BENCH_RAW_PHYSICS_H_
