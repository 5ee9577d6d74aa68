#ifndef SINEW_TOOLS_BENCH_ACTOR_FIGURES_H_
#define SINEW_TOOLS_BENCH_ACTOR_FIGURES_H_

#include <memory>

#include "absl/status/statusor.h"
#include "actor/rollout_assets.h"
#include "proto/sinew/v1/snapshot.pb.h"

namespace sinew::bench {

// How much of an actor's time is physics. A round of a thread runs one training
// order with its RolloutWorker (observation, policy, reward, encoding, the
// segment's bytes) and steps the same states under the same torques in a plain
// loop around mj_step (all but the first step of each episode); that both go
// through the same states is checked bit for bit. Both, and the policy's
// products, are timed in turns, and the fastest of each turn's kind counts:
// what else runs on the machine only ever adds to a time. (Caches are warm: an
// order is run once before it is timed.) Times are CPU seconds of the thread; a
// figure is the median over rounds and threads.
struct ActorFigures {
  int threads = 0;
  // mj_step per second inside rollouts, over raw_steps_per_s.
  double ratio = 0;
  double rollout_steps_per_s = 0;  // mj_step, one thread
  double raw_steps_per_s = 0;      // mj_step, one thread
  // Microseconds of a control step: all of it, what is not mj_step, and the
  // matrix products of the policy alone (same kernel and batch).
  double step_us = 0;
  double other_us = 0;
  double products_us = 0;
};

struct ActorOptions {
  int threads = 1;       // >= 1
  int rounds = 6;        // per thread, >= 1
  int repetitions = 5;   // of a round's measurements, >= 1
  int environments = 8;  // per order
  int horizon = 64;      // control steps of an order
};

// `snapshot` acts; its policy should survive, as a trained one does.
//
// Blocking: about a second per round. Errors: those of RolloutWorker;
// INVALID_ARGUMENT for recipes whose physics is more than the plain loop knows
// (randomised, or with an actuator model); INTERNAL if the raw loop does not
// reproduce the rollout's states.
absl::StatusOr<ActorFigures> MeasureActor(
    const ActorOptions& options,
    const std::shared_ptr<const actor::RolloutAssets>& assets,
    const v1::Snapshot& snapshot);

// A policy of the recipe's size that does nothing: mean action zero, small
// noise. What it costs does not depend on its weights.
absl::StatusOr<v1::Snapshot> IdlePolicy(const actor::RolloutAssets& assets);

}  // namespace sinew::bench

#endif  // SINEW_TOOLS_BENCH_ACTOR_FIGURES_H_
