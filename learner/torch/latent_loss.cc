#include "learner/torch/latent_loss.h"

#include <ATen/ATen.h>

namespace sinew::learner {
namespace {

using at::Tensor;

constexpr double kLargestKl = 1e5;

}  // namespace

Tensor GaussianKl(const Tensor& mean, const Tensor& log_variance,
                  const Tensor& prior_mean, const Tensor& prior_log_variance) {
  const Tensor distance = log_variance.exp() + (mean - prior_mean).square();
  return (0.5 * (prior_log_variance - log_variance) +
          0.5 * distance * (-prior_log_variance).exp() - 0.5)
      .sum(1);
}

Tensor LatentKlSum(const Tensor& mean, const Tensor& log_variance,
                   const Tensor& prior_mean, const Tensor& prior_log_variance,
                   const Tensor& weight) {
  const Tensor kl = at::clamp_max(
      GaussianKl(mean, log_variance, prior_mean, prior_log_variance),
      kLargestKl);
  return (kl * weight).sum();
}

}  // namespace sinew::learner
