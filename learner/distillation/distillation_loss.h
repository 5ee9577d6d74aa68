#ifndef SINEW_LEARNER_DISTILLATION_DISTILLATION_LOSS_H_
#define SINEW_LEARNER_DISTILLATION_DISTILLATION_LOSS_H_

#include <ATen/core/Tensor.h>

#include <cstdint>

#include "proto/sinew/v1/distillation.pb.h"

namespace sinew::learner {

// The loss of a student that imitates a teacher through a latent (Luo et al.,
// "Universal humanoid motion representations for physics-based control", 2024,
// equation 3), over the rows of a minibatch: sequences of T steps each.
//
//   a_t       action of the student, for one noise of the latent
//   a*_t      label: the action that would ask for the teacher's target
//   m_t, l_t  posterior: mean, logarithm of the variance, per dimension
//   p_t, r_t  prior: likewise
//   w_t       1 where the row is valid, else 0; N = sum of w over the minibatch
//   c_t       1 where row t goes on from row t - 1; P = sum of c, at least 1
//
//   KL_t = sum over dimensions (r - l) / 2 + (e^l + (m - p)^2) / (2 e^r) - 1/2
//
//   PAPER  action     = sum w_t |a_t - a*_t|^2 / N
//          continuity = sum c_t |m_t - m_{t-1}|^2 / P
//   CODE   action     = sum w_t |a_t - a*_t| / N
//          continuity = sum c_t |m_t - 0.99 m_{t-1}| / P
//   both   latent_kl  = sum w_t min(KL_t, 1e5) / N
//
//   loss = action + continuity_weight * continuity + kl_weight * latent_kl
//
// |x| is the Euclidean norm, over joints and over dimensions of the latent; a
// plain one is sqrt(|x|^2 + 1e-12), so that it has a gradient at 0. The weights
// of one form mean nothing in the other. latent_kl and its limit are those of
// learner/torch/latent_loss.h.
//
// Without a latent (`posterior_mean` undefined): loss = action.
//
// Thread-safety: pure functions. Ownership: none. Blocking: compute on the
// calling thread. Errors: throw c10::Error for shapes that do not fit. Numbers
// that are not finite pass through.

// Of a shard: n = sequences * T rows, A joints, Z dimensions.
struct DistillationTensors {
  at::Tensor action, label;  // [n, A]
  // [n, Z], or undefined.
  at::Tensor posterior_mean = {}, posterior_log_variance = {};
  at::Tensor prior_mean = {}, prior_log_variance = {};
  at::Tensor valid, linked;  // [n]
};

struct DistillationWeights {
  v1::Distillation::Form form = v1::Distillation::FORM_CODE;
  double kl = 0;
  double continuity = 0;
  // 1 / N and 1 / P of the whole minibatch.
  double row_scale = 0;
  double pair_scale = 0;
};

// Parts of the loss, not yet weighed; scalars, differentiable. Those without a
// latent are undefined.
struct DistillationTerms {
  at::Tensor loss;        // the sum that is minimised
  at::Tensor action;      // sum w ... / N
  at::Tensor latent_kl;   // sum w ... / N
  at::Tensor continuity;  // sum c ... / P
  at::Tensor row_action;  // [n], w_t |...|, not differentiable
};

DistillationTerms DistillationLoss(const DistillationTensors& tensors,
                                   int64_t steps,
                                   const DistillationWeights& weights);

}  // namespace sinew::learner

#endif  // SINEW_LEARNER_DISTILLATION_DISTILLATION_LOSS_H_
