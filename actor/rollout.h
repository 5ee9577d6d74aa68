#ifndef SINEW_ACTOR_ROLLOUT_H_
#define SINEW_ACTOR_ROLLOUT_H_

#include <mujoco/mujoco.h>

#include <atomic>
#include <functional>
#include <memory>

#include "absl/status/statusor.h"
#include "absl/types/span.h"
#include "actor/prepared_snapshot.h"
#include "actor/rollout_assets.h"
#include "proto/sinew/v1/rollout.pb.h"

namespace sinew::actor {

// Runs orders one after another on one thread: segment =
// rollout(order, snapshot, assets), a pure function of those three, except for
// Segment.seconds.
//
// KIND_TRAIN, T steps of E environments in lockstep:
//   for t in 0 .. T-1:
//     1. an environment without physics starts episode `episode` afresh
//     2. observe all; one forward pass; noise keyed by (seed, environment,
//        episode, step, kAction)
//     3. target, physics, reward, termination of each; write row t
//     4. an episode that ended leaves its environment without physics and with
//        the next episode number
//   boundary observations, end states. Columns: common/segment/
//   segment_layout.h, in that order.
// Where the recipe distils, columns base and teacher_base tell what both action
// laws add to actions, and in their shares of the episodes
// (common/segment/episode_actor.h) the snapshot's graph "teacher" acts, with
// its mean, by its own law, or its graph "sample", the prior with noise, by the
// policy's; what the student does in its own has noise of action_noise, which
// column action has and log_probability leaves out. Where PPO learns a latent,
// column latent_noise has the part of the step's noise that chose it.
// Where a get-up is over, step 4 leaves the body where it is, if a frame that
// stays up is within the limit of termination (TrackingTask::CarryOn); so it
// does after a share of all clips (task.start.carry_on_share), and where an
// episode of the prior ends, at any frame of the library.
// A diverged simulation (sim/world/actuation.h) is no error: its step is marked
// invalid, its episode ends with REASON_DIVERGED, the environment starts anew.
//
// KIND_EVALUATE: noise zero, start noise zero, each start until its mean body
// distance exceeds evaluation.max_mean_body_distance, or `steps` are survived;
// one result per start, no columns. A divergence is a failure. Starts are
// independent of each other. A start that names a fallen state runs all its
// steps and says from which frame on the body stood and tracked to the end; on
// a get-up it goes on once that is over, or has failed if no frame is near.
//
// Thread-safety: one worker per thread. Ownership: shares assets. Blocking:
// Run computes for milliseconds to seconds and checks `cancel` every control
// step. Errors: INVALID_ARGUMENT for an order that does not fit (names field,
// expected, found); FAILED_PRECONDITION for a policy whose output is not
// finite, and where MuJoCo gives up outside of a step (within one it is a
// divergence); CANCELLED. Nothing allocates per step once a segment's columns
// are there, except where an episode ends.
class RolloutWorker {
 public:
  // Called after each step of an evaluation, that in which a start fails among
  // them (unless it diverged), with data whose bodies and geoms are placed:
  // start's index, the frame reached, counted from the start (>= 1), and the
  // latent that the step was taken with (the policy's tap "latent"; without
  // noise its encoder's mean), empty where it has none.
  using FrameObserver =
      std::function<void(int start, int frame, const mjData& data,
                         absl::Span<const float> latent)>;

  static absl::StatusOr<std::unique_ptr<RolloutWorker>> Create(
      std::shared_ptr<const RolloutAssets> assets, int max_environments);
  virtual ~RolloutWorker() = default;

  virtual absl::StatusOr<v1::Segment> Run(
      const v1::Order& order, const PreparedSnapshot& snapshot,
      const std::atomic<bool>* cancel = nullptr) = 0;

  // For pictures and figures per frame; unset by default.
  virtual void SetFrameObserver(FrameObserver observer) = 0;
};

}  // namespace sinew::actor

#endif  // SINEW_ACTOR_ROLLOUT_H_
