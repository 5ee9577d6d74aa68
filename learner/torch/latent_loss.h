#ifndef SINEW_LEARNER_TORCH_LATENT_LOSS_H_
#define SINEW_LEARNER_TORCH_LATENT_LOSS_H_

#include <ATen/core/Tensor.h>

namespace sinew::learner {

// What holds a latent near its prior, whoever learns it: diagonal Gaussians,
// each by its mean and the logarithm of its variance, [n, Z].
//
//   KL = sum over dimensions (r - l) / 2 + (e^l + (m - p)^2) / (2 e^r) - 1/2
//
// with the posterior's m and l, the prior's p and r.
//
// Thread-safety: pure functions. Ownership: none. Blocking: compute on the
// calling thread. Errors: throw c10::Error for shapes that do not fit. Numbers
// that are not finite pass through.

// KL of every row, [n].
at::Tensor GaussianKl(const at::Tensor& mean, const at::Tensor& log_variance,
                      const at::Tensor& prior_mean,
                      const at::Tensor& prior_log_variance);

// sum over rows of w min(KL, 1e5), a scalar, differentiable; w [n] is 1 where
// the row is valid, else 0. A row whose KL is above the limit counts with the
// limit and has no gradient of it: a guard, beside the clamp on log variances
// in the graph, that never ends a run.
at::Tensor LatentKlSum(const at::Tensor& mean, const at::Tensor& log_variance,
                       const at::Tensor& prior_mean,
                       const at::Tensor& prior_log_variance,
                       const at::Tensor& weight);

}  // namespace sinew::learner

#endif  // SINEW_LEARNER_TORCH_LATENT_LOSS_H_
