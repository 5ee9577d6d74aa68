#include "learner/torch/latent_loss.h"

#include <ATen/ATen.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <vector>

#include "absl/types/span.h"
#include "common/random/philox.h"

namespace sinew::learner {
namespace {

using at::Tensor;

constexpr int kRows = 5, kLatents = 3;

Tensor Draw(uint64_t seed) {
  std::vector<float> values(kRows * kLatents);
  FillNormal({.seed = seed}, absl::MakeSpan(values));
  return at::from_blob(values.data(), {kRows, kLatents}, at::kFloat)
      .to(at::kDouble);
}

TEST(GaussianKl, IsZeroOfAGaussianToItself) {
  const Tensor mean = Draw(1), log_variance = Draw(2);

  const Tensor kl = GaussianKl(mean, log_variance, mean, log_variance);

  EXPECT_LT(kl.abs().max().item<double>(), 1e-12);
}

// By standard deviations, number by number.
TEST(GaussianKl, IsTheFormulaOfStandardDeviations) {
  const Tensor mean = Draw(1), log_variance = Draw(2) * 0.5;
  const Tensor prior_mean = Draw(3), prior_log_variance = Draw(4) * 0.5;

  const Tensor kl =
      GaussianKl(mean, log_variance, prior_mean, prior_log_variance);

  for (int row = 0; row < kRows; ++row) {
    double expected = 0;
    for (int z = 0; z < kLatents; ++z) {
      const double s = std::exp(log_variance[row][z].item<double>() / 2);
      const double r = std::exp(prior_log_variance[row][z].item<double>() / 2);
      const double d = (mean[row][z] - prior_mean[row][z]).item<double>();
      expected += std::log(r / s) + (s * s + d * d) / (2 * r * r) - 0.5;
    }
    EXPECT_NEAR(kl[row].item<double>(), expected, 1e-12);
  }
}

TEST(LatentKlSum, LeavesRowsWithoutWeightOutAndLimitsTheRest) {
  Tensor mean = Draw(1);
  const Tensor log_variance = Draw(2), prior_mean = Draw(3),
               prior_log_variance = Draw(4);
  mean[1][0] = 1e6;
  const Tensor kl =
      GaussianKl(mean, log_variance, prior_mean, prior_log_variance);
  Tensor weight = at::ones({kRows}, at::kDouble);
  weight[3] = 0;

  const double sum =
      LatentKlSum(mean, log_variance, prior_mean, prior_log_variance, weight)
          .item<double>();

  EXPECT_GT(kl[1].item<double>(), 1e6);
  EXPECT_NEAR(sum, (kl[0] + kl[2] + kl[4]).item<double>() + 1e5, 1e-6);
}

}  // namespace
}  // namespace sinew::learner
