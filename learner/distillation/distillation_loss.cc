#include "learner/distillation/distillation_loss.h"

#include <ATen/ATen.h>

#include "learner/torch/latent_loss.h"

namespace sinew::learner {
namespace {

using at::Tensor;

constexpr double kNormFloor = 1e-12;
constexpr double kDecay = 0.99;  // of the previous mean, form CODE

// |x|^2 or |x| of every row.
Tensor Distance(const Tensor& difference, v1::Distillation::Form form) {
  const Tensor squares = difference.square().sum(1);
  if (form == v1::Distillation::FORM_PAPER) return squares;
  return (squares + kNormFloor).sqrt();
}

// sum c_t |m_t - d m_{t-1}| over sequences of `steps` rows.
Tensor ContinuitySum(const Tensor& mean, const Tensor& linked, int64_t steps,
                     v1::Distillation::Form form) {
  if (steps < 2) return mean.sum() * 0;
  const int64_t width = mean.size(1);
  const Tensor sequences = mean.view({-1, steps, width});
  const Tensor now = sequences.narrow(1, 1, steps - 1);
  const Tensor before = sequences.narrow(1, 0, steps - 1);
  const double decay = form == v1::Distillation::FORM_PAPER ? 1.0 : kDecay;
  const Tensor difference = (now - before * decay).reshape({-1, width});
  const Tensor pairs =
      linked.view({-1, steps}).narrow(1, 1, steps - 1).reshape({-1});
  return (Distance(difference, form) * pairs).sum();
}

}  // namespace

DistillationTerms DistillationLoss(const DistillationTensors& tensors,
                                   int64_t steps,
                                   const DistillationWeights& weights) {
  DistillationTerms terms;
  const Tensor rows =
      Distance(tensors.action - tensors.label, weights.form) * tensors.valid;
  terms.row_action = rows.detach();
  terms.action = rows.sum() * weights.row_scale;
  terms.loss = terms.action;
  if (!tensors.posterior_mean.defined()) return terms;
  terms.latent_kl =
      LatentKlSum(tensors.posterior_mean, tensors.posterior_log_variance,
                  tensors.prior_mean, tensors.prior_log_variance,
                  tensors.valid) *
      weights.row_scale;
  terms.continuity = ContinuitySum(tensors.posterior_mean, tensors.linked,
                                   steps, weights.form) *
                     weights.pair_scale;
  terms.loss = terms.action + terms.continuity * weights.continuity +
               terms.latent_kl * weights.kl;
  return terms;
}

}  // namespace sinew::learner
