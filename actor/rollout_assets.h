#ifndef SINEW_ACTOR_ROLLOUT_ASSETS_H_
#define SINEW_ACTOR_ROLLOUT_ASSETS_H_

#include <memory>
#include <string>
#include <variant>

#include "absl/base/call_once.h"
#include "absl/status/statusor.h"
#include "common/mapped_file.h"
#include "proto/sinew/v1/rollout.pb.h"
#include "proto/sinew/v1/state_limits.pb.h"
#include "sim/character/character.h"
#include "sim/motion/library.h"
#include "sim/world/fallen_states.h"
#include "sim/world/nearest_frame.h"
#include "sim/world/tracking_task.h"

namespace sinew::actor {

// Everything constant that the rollouts of one TaskAssets share: character,
// library, recipe, task, layout of segments.
//
// Thread-safety: immutable. Ownership: owns all parts; workers and snapshots
// share it. Blocking: only the factories compute (parsing, digests). Errors:
// the factories say which asset (role) does not fit, expected and found.
class RolloutAssets {
 public:
  // From the bytes of the assets, by role as in TaskAssets; "fallen" may be
  // empty, that is none. Frames in memory are copied, those in a file shared.
  using Frames =
      std::variant<absl::string_view, std::shared_ptr<const MappedFile>>;
  static absl::StatusOr<std::shared_ptr<const RolloutAssets>> Create(
      absl::string_view character_text, absl::string_view model_binary,
      absl::string_view library_manifest, const Frames& frames,
      absl::string_view recipe_text, absl::string_view fallen = "");

  // From parts that are there already. `recipe` has its defaults filled.
  static absl::StatusOr<std::shared_ptr<const RolloutAssets>> FromParts(
      const v1::Recipe& recipe,
      std::unique_ptr<const character::Character> character,
      std::unique_ptr<const motion::Library> library,
      std::unique_ptr<const world::FallenStates> fallen = nullptr);

  const world::TrackingTask& task() const { return *task_; }
  const v1::Recipe& recipe() const { return task_->recipe(); }
  // Where bodies go on that the prior has led (TrackingTask::CarryOn); made
  // when first asked for, which reads the library, and shared from then on.
  const world::NearestFrames& nearest_frames() const;
  // The same after a get-up (world::UprightFrames), and after other clips
  // (those that stay up for task.start.carry_on_seconds).
  const world::NearestFrames& upright_frames() const;
  const world::NearestFrames& onward_frames() const;
  // Columns of a training segment, and the digest of the layout.
  const v1::SegmentLayout& layout() const { return layout_; }
  const std::string& layout_sha256() const { return layout_sha256_; }
  // What states of environments may hold, end states of segments as well.
  const v1::StateLimits& limits() const { return limits_; }

 private:
  RolloutAssets() = default;

  std::unique_ptr<const character::Character> character_;
  std::unique_ptr<const motion::Library> library_;
  std::unique_ptr<const world::FallenStates> fallen_;  // may be null
  std::unique_ptr<const world::TrackingTask> task_;
  v1::SegmentLayout layout_;
  std::string layout_sha256_;
  v1::StateLimits limits_;
  std::unique_ptr<const world::NearestFrames> StaysUpFor(double seconds) const;

  mutable absl::once_flag nearest_once_, upright_once_, onward_once_;
  mutable std::unique_ptr<const world::NearestFrames> nearest_frames_,
      upright_frames_, onward_frames_;
};

}  // namespace sinew::actor

#endif  // SINEW_ACTOR_ROLLOUT_ASSETS_H_
