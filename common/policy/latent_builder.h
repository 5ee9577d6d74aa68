#ifndef SINEW_COMMON_POLICY_LATENT_BUILDER_H_
#define SINEW_COMMON_POLICY_LATENT_BUILDER_H_

#include <cstdint>

#include "absl/status/statusor.h"
#include "common/policy/safetensors.h"
#include "proto/sinew/v1/graph.pb.h"
#include "proto/sinew/v1/recipe.pb.h"

namespace sinew::policy {

// The networks of a policy with a latent (Luo et al., PULSE, 2024, equations 1
// and 2): what a recipe's Network.latent means. The first S of O observation
// columns are the body's own state (blocks SELF_...), the others its goal; Z is
// the latent's width, A the action's.
//
// Graphs share parameters by name. `own` and `goal` stand for
//   own_normalised, own_clipped     NORMALISE, CLAMP of the S columns
//   goal_normalised, goal_clipped   the same of the O - S others
//
// "encoder": observation [O] (DATA)
//   encoder_input      CONCAT of own_clipped, goal_clipped
//   encoder_hidden_i, encoder_hidden_i_activation     of encoder_hidden
//   posterior_mean     LINEAR, Z
//   posterior_log_variance_free, posterior_log_variance
//                      LINEAR, Z; CLAMP of it to log_variance_low .. high
//   posterior_half_log_variance, posterior_std
//                      AFFINE by "latent/half"; EXP of it
//   taps: "mean", "std" and "log_variance" of the posterior
// "prior": self_observation [S] (DATA)
//   prior_hidden_i ..., prior_mean, prior_log_variance, prior_std; taps as
//   above
// "decoder": self_observation [S], latent [Z] (DATA)
//   decoder_hidden_i ... of CONCAT of own_clipped, latent; then action, LINEAR
//   tap: "action" (executed)
// "sample": self_observation [S] (DATA), noise [Z] (NORMAL)
//   the prior, latent = prior_mean + prior_std * noise, the decoder
//   taps: "action" (executed), "latent"
// "policy": observation [O] (DATA), noise [Z] (NORMAL)
//   the encoder, latent = posterior_mean + posterior_std * noise, the decoder
//   taps: "action" (executed, recorded), "mean" (recorded; the same value),
//   "latent". No tap has a distribution: the policy's only noise is the latent.
//   Noise 0 gives the action of the posterior's mean.
//
// Where it is to be learnt by PPO (`explores`), the decoder's action is the
// mean of a Gaussian, and there is a critic:
//
// "policy": observation [O] (DATA), noise [Z] (NORMAL), action_noise [A]
// (NORMAL)
//   as above, but the decoder's last node is "mean"
//   exploration        AFFINE of action_noise by "policy/std"
//   action             ADD of mean, exploration
//   taps: "action" (executed, recorded, Gaussian around "mean" with
//   "policy/std"), "mean" (recorded), "latent", "latent_noise" (recorded; the
//   input noise). The Gaussian is that of the action given the latent's noise.
// "critic": observation [O] (DATA)
//   critic_input       CONCAT of own_clipped, goal_clipped
//   critic_hidden_i ... of value_hidden; then value, LINEAR, 1
//   tap: "value"
//
// Parameters (float32), F: frozen
//   normaliser/own/mean, .../inverse_std     [S]      0, 1   F
//   normaliser/goal/mean, .../inverse_std    [O - S]  0, 1   F
//   encoder/linear_i/..., encoder/mean/..., encoder/log_variance/...
//   prior/linear_i/..., prior/mean/..., prior/log_variance/...
//   decoder/linear_i/..., decoder/action/...
//   latent/half                              [Z]      0.5    F
//   if it explores: policy/std               [A]      initial_std  F
//     critic/linear_i/..., critic/value/... (gain 1)
//     weights orthogonal, gain sqrt(2), of last layers last_layer_gain;
//     biases 0
struct LatentPolicyOptions {
  // S >= 1, O > S, A >= 1.
  int64_t self_observation_width = 0;
  int64_t observation_width = 0;
  int64_t action_width = 0;
  // With defaults filled and `latent` set (common/config/recipe.h).
  v1::Network network{};
  // Learnt by PPO: with exploration and critic.
  bool explores = false;
};

// All graphs. INVALID_ARGUMENT names the option, expected and found.
//
// Thread-safety: pure functions. Blocking: InitialLatentWeights computes for a
// fraction of a second.
absl::StatusOr<v1::PolicyGraph> BuildLatentPolicy(
    const LatentPolicyOptions& options);

// The initial weights of the table above; a function of options and seed, as
// InitialWeights of builder.h.
absl::StatusOr<TensorMap> InitialLatentWeights(
    const LatentPolicyOptions& options, uint64_t seed);

}  // namespace sinew::policy

#endif  // SINEW_COMMON_POLICY_LATENT_BUILDER_H_
