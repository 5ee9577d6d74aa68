#ifndef SINEW_ACTOR_ROLLOUT_H_
#define SINEW_ACTOR_ROLLOUT_H_

#include <memory>
#include <string>

#include "absl/status/statusor.h"
#include "proto/sinew/v1/rollout.pb.h"
#include "proto/sinew/v1/snapshot.pb.h"
#include "sim/world/tracking_task.h"

namespace sinew::actor {

// Everything constant that rollouts of one TaskAssets share: character,
// library, recipe, task. Thread-safe, immutable.
class RolloutAssets {
 public:
  // `get` returns an asset's bytes by role. Errors name the asset.
  static absl::StatusOr<std::shared_ptr<const RolloutAssets>> Create(
      std::string_view character_text, std::string_view model_binary,
      std::string_view library_manifest, std::string_view frames,
      std::string_view recipe_text);
  virtual ~RolloutAssets() = default;
  virtual const world::TrackingTask& task() const = 0;
  // Columns of a training segment, and the digest of the layout.
  virtual const v1::SegmentLayout& layout() const = 0;
  virtual const std::string& layout_sha256() const = 0;
};

// A snapshot made ready to act with: packed weights, start table.
class PreparedSnapshot;
absl::StatusOr<std::shared_ptr<const PreparedSnapshot>> PrepareSnapshot(
    const v1::Snapshot& snapshot, const std::string& sha256,
    const RolloutAssets& assets);

// Runs orders one after another on one thread: segment =
// rollout(order, snapshot, assets), a pure function of those three.
//
// Columns of a training segment ([T, E, ...]): "observation" [O] float32,
// "action" [A] float32 (as sampled), "action_mean" [A], "target" [J] float64,
// "log_probability" float32, "reward" float32, "reward_terms" [4] float32,
// "body_distance" float32, "terminated" uint8, "truncated" uint8, "valid"
// uint8, "clip" int32, "frame" int32 (reference frame at s_t, before the
// step), "next_observation" — only where needed: "boundary_observation"
// [E, O]: observation after the last step; truncated steps inside the segment
// carry their successor's observation in "truncation_observation"
// [T * E at most: rows packed, see "truncation_index" int32].
//
// Thread-safety: one worker per thread. Ownership: shares assets. Blocking:
// Run computes for milliseconds to seconds and checks `cancel` every control
// step. Errors: INVALID_ARGUMENT for an order that does not fit (names field,
// expected, found); CANCELLED. A diverged simulation is not an error: its
// environment starts a new episode, its step is marked invalid and counted.
class RolloutWorker {
 public:
  static absl::StatusOr<std::unique_ptr<RolloutWorker>> Create(
      std::shared_ptr<const RolloutAssets> assets, int max_environments);
  virtual ~RolloutWorker() = default;
  virtual absl::StatusOr<v1::Segment> Run(
      const v1::Order& order, const PreparedSnapshot& snapshot,
      const std::atomic<bool>* cancel = nullptr) = 0;
};

}  // namespace sinew::actor

#endif  // SINEW_ACTOR_ROLLOUT_H_
