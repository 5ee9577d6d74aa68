#ifndef SINEW_ACTOR_WORKER_STATE_H_
#define SINEW_ACTOR_WORKER_STATE_H_

#include <atomic>
#include <chrono>
#include <memory>
#include <vector>

#include "absl/status/status.h"
#include "actor/environment.h"
#include "actor/physics_batch.h"
#include "actor/policy_runner.h"
#include "actor/prepared_snapshot.h"
#include "actor/rollout.h"
#include "actor/rollout_assets.h"
#include "common/segment/episode_actor.h"
#include "proto/sinew/v1/rollout.pb.h"
#include "sim/world/tracking_task.h"

namespace sinew::actor {

// What one worker thread keeps between orders: buffers, nothing that a result
// depends on.
struct WorkerState {
  // `batch` has a row for each environment.
  WorkerState(std::shared_ptr<const RolloutAssets> shared_assets,
              PhysicsBatch physics_batch);

  const std::shared_ptr<const RolloutAssets> assets;
  const world::TrackingTask& task;
  PhysicsBatch batch;
  const std::unique_ptr<world::TrackingTask::Workspace> work;
  PolicyRunner policy;
  PolicyRunner teacher, prior;            // unused if the snapshot has none
  std::vector<Environment> environments;  // [batch.size()]
  // Where bodies go on after the prior's episodes, after get-ups, and after
  // other clips; of the assets, null until an order has come that may need
  // them.
  const world::NearestFrames* nearest = nullptr;
  const world::NearestFrames* upright = nullptr;
  const world::NearestFrames* onward = nullptr;
  // Of the step at hand: who acts in an environment [batch.size()]; target and
  // bases [J].
  struct Acting {
    EpisodeActor actor = EpisodeActor::kPolicy;
    const PolicyRunner* runner = nullptr;
    int row = 0;  // of the runner
  };
  std::vector<Acting> acting;
  std::vector<double> target, base, teacher_base;
  std::vector<float> noisy_action;  // [J] of the step at hand, where it has
                                    // noise
  RolloutWorker::FrameObserver observer;
};

// Adds the seconds since the last lap to whatever the time was spent on.
class StageClock {
 public:
  void Lap(double* stage) {
    const auto now = std::chrono::steady_clock::now();
    *stage += std::chrono::duration<double>(now - last_).count();
    last_ = now;
  }

 private:
  std::chrono::steady_clock::time_point last_ =
      std::chrono::steady_clock::now();
};

// Seconds of one rollout.
struct Stages {
  double simulate = 0, infer = 0, observe = 0;
};

// CANCELLED if asked for.
absl::Status CheckCancelled(const std::atomic<bool>* cancel,
                            const v1::Order& order);

// FAILED_PRECONDITION if action, mean or log-probability of a row is not
// finite.
absl::Status CheckPolicyOutput(const PolicyRunner& policy, int row,
                               double log_probability,
                               const PreparedSnapshot& snapshot);

// The two kinds of orders; preconditions checked by RolloutWorker::Run.
absl::Status RunTraining(const v1::Order& order,
                         const PreparedSnapshot& snapshot,
                         const std::atomic<bool>* cancel, WorkerState& state,
                         v1::Segment* segment);
absl::Status RunEvaluation(const v1::Order& order,
                           const PreparedSnapshot& snapshot,
                           const std::atomic<bool>* cancel, WorkerState& state,
                           v1::Segment* segment);

}  // namespace sinew::actor

#endif  // SINEW_ACTOR_WORKER_STATE_H_
