#ifndef SINEW_LEARNER_PPO_PPO_LEARNER_H_
#define SINEW_LEARNER_PPO_PPO_LEARNER_H_

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/types/span.h"
#include "common/policy/safetensors.h"
#include "common/segment/mirror.h"
#include "learner/ppo/initial_weights.h"
#include "proto/sinew/v1/graph.pb.h"
#include "proto/sinew/v1/recipe.pb.h"
#include "proto/sinew/v1/rollout.pb.h"
#include "proto/sinew/v1/training_state.pb.h"

namespace sinew::learner {

// Figures of one update; names as in metrics.jsonl.
struct UpdateStatistics {
  int64_t samples = 0;  // valid rows used
  int32_t epochs = 0;   // passes done before the KL stop
  double policy_loss = 0, value_loss = 0, entropy = 0;
  double kl = 0;  // mean KL(old || new) after the last pass
  double clip_fraction = 0;
  double policy_gradient_norm = 0, value_gradient_norm = 0;  // mean, unclipped
  double explained_variance = 0;
  double reward_mean = 0;
  std::vector<double> reward_terms;  // means
  double body_distance_mean_m = 0;
  double policy_learning_rate = 0, value_learning_rate = 0, std_factor = 1;
  int64_t non_finite = 0;  // minibatches skipped for non-finite loss
  double flops = 0;        // multiply-adds * 2 of the update, computed
};

// PPO over segments: GAE (terminated: value 0; truncated: bootstrap from the
// successor's value; segment end: bootstrap from boundary_observation), value
// targets scaled by (1 - discount), advantages normalised over the batch,
// clipped objective, KL stop, separate policy and value networks, running
// observation normaliser (a NORMALISE node; statistics frozen inside an
// update, merged after it). Gradients are summed over `ppo.shards` in fixed
// order whatever the number of ranks (threads), so the result is a pure
// function of (state, segments, recipe).
//
// Under network.composer the policy's primitives are frozen: they are computed
// once per update, and part of the state, so that a run resumes without their
// bundles. They come by Load, InitFrom or InitFromPrimitives before the first
// Update.
//
// Thread-safety: one caller. Ownership: owns networks and `ranks` threads.
// Blocking: Update computes for up to seconds. Errors: INVALID_ARGUMENT for
// segments or weights that do not fit, nothing has changed then;
// FAILED_PRECONDITION at Create for bfloat16 on a CPU without it, or "cuda"
// without a device, saying what was asked and found, and at Update for a
// composer without primitives.
class PpoLearner {
 public:
  struct Options {
    int observation_width = 0;
    int action_width = 0;
    int ranks = 1;  // threads, >= 1
    // Of the task; needed if the recipe says ppo.mirror.
    std::optional<SegmentMirror> mirror = std::nullopt;
  };
  static absl::StatusOr<std::unique_ptr<PpoLearner>> Create(
      const v1::Recipe& recipe, const Options& options);
  virtual ~PpoLearner() = default;

  // One iteration over the segments of all orders, sorted by order_id.
  virtual absl::StatusOr<UpdateStatistics> Update(
      absl::Span<const v1::Segment* const> segments, int64_t iteration) = 0;

  // Graphs "policy" (inputs "observation" DATA, "noise" NORMAL; taps "action"
  // executed + recorded with a Gaussian of parameter "policy/std", "mean"
  // recorded) and "critic" (tap "value").
  virtual const v1::PolicyGraph& graph() const = 0;
  // Current weights, normaliser included (float32).
  virtual TensorMap weights() const = 0;

  // Whole learning state: weights, Adam moments, normaliser sums (float64),
  // and counters in `state` (fields the learner owns: optimiser steps,
  // learning_rate_factor, normaliser_count). Load then Update gives the same
  // bits as never having stopped.
  virtual TensorMap SaveTensors() const = 0;
  virtual void SaveCounters(v1::TrainingState& state) const = 0;
  virtual absl::Status Load(const TensorMap& tensors,
                            const v1::TrainingState& state) = 0;
  // Weights only (--init BUNDLE): parameters of equal name and shape, the
  // policy's all of them.
  virtual absl::Status InitFrom(const TensorMap& weights) = 0;
  // Of a recipe with network.composer: the frozen policies that it weighs
  // (--primitives BUNDLES), in their order.
  virtual absl::Status InitFromPrimitives(
      absl::Span<const Primitive> primitives) = 0;

  // Annealing: factors on std and learning rates, in effect from the next
  // snapshot / update on.
  virtual void SetFactors(double std_factor, double learning_rate_factor) = 0;
};

}  // namespace sinew::learner

#endif  // SINEW_LEARNER_PPO_PPO_LEARNER_H_
