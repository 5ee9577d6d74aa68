#ifndef SINEW_LEARNER_PPO_PPO_LEARNER_H_
#define SINEW_LEARNER_PPO_PPO_LEARNER_H_

#include <memory>
#include <optional>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/types/span.h"
#include "common/segment/mirror.h"
#include "learner/learner.h"
#include "learner/update/initial_weights.h"
#include "proto/sinew/v1/recipe.pb.h"

namespace sinew::learner {

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
// Under network.latent (without distillation) the policy goes through encoder
// and decoder, and the encoder's posterior is held near the learned prior by
// ppo.latent_kl_weight: PULSE's lower bound, a latent from rewards alone. The
// policy is the one given the latent's noise, which segments record; exact
// loss: ppo_networks.h.
//
// graph() has "policy" (inputs "observation" DATA, "noise" NORMAL; taps
// "action" executed + recorded with a Gaussian of parameter "policy/std",
// "mean" recorded) and "critic" (tap "value"); with a latent the graphs of
// common/policy/latent_builder.h that explore. Of the counters in a state it
// owns optimiser steps, learning_rate_factor and normaliser_count; it has no
// chunks.
//
// Thread-safety: one caller. Ownership: owns networks and `ranks` threads.
// Blocking: Update computes for up to seconds. Errors: INVALID_ARGUMENT for
// segments or weights that do not fit, nothing has changed then;
// FAILED_PRECONDITION at Create for bfloat16 on a CPU without it, or "cuda"
// without a device, saying what was asked and found, and at Update for a
// composer without primitives.
class PpoLearner : public Learner {
 public:
  struct Options {
    int observation_width = 0;
    // Leading columns of the observation that prior and decoder see; with a
    // latent.
    int self_observation_width = 0;
    int action_width = 0;
    int ranks = 1;  // threads, >= 1
    // Of the task; needed if the recipe says ppo.mirror.
    std::optional<SegmentMirror> mirror = std::nullopt;
  };
  static absl::StatusOr<std::unique_ptr<PpoLearner>> Create(
      const v1::Recipe& recipe, const Options& options);

  // Of a recipe with network.composer: the frozen policies that it weighs
  // (--primitives BUNDLES), in their order.
  virtual absl::Status InitFromPrimitives(
      absl::Span<const Primitive> primitives) = 0;
};

}  // namespace sinew::learner

#endif  // SINEW_LEARNER_PPO_PPO_LEARNER_H_
