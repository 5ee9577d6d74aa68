#include "learner/distillation/distillation_loss.h"

#include <ATen/ATen.h>
#include <gtest/gtest.h>
#include <torch/csrc/autograd/autograd.h>

#include <cmath>
#include <functional>
#include <vector>

#include "absl/types/span.h"
#include "common/random/philox.h"

namespace sinew::learner {
namespace {

using at::Tensor;

constexpr int kSequences = 3, kSteps = 4, kActions = 2, kLatents = 3;
constexpr int kRows = kSequences * kSteps;

// Numbers of N(0, 1), in double, so that differences are exact enough.
Tensor Draw(uint64_t seed, at::IntArrayRef shape) {
  int64_t size = 1;
  for (const int64_t extent : shape) size *= extent;
  std::vector<float> values(size);
  FillNormal({.seed = seed}, absl::MakeSpan(values));
  return at::from_blob(values.data(), shape, at::kFloat).to(at::kDouble);
}

Tensor Flags(std::vector<double> values) {
  return at::from_blob(values.data(), {kRows}, at::kDouble).clone();
}

// Row 2 is not valid, row 6 begins an episode, rows 0, 4 and 8 a sequence.
DistillationTensors Tensors() {
  return {.action = Draw(1, {kRows, kActions}),
          .label = Draw(2, {kRows, kActions}),
          .posterior_mean = Draw(3, {kRows, kLatents}),
          .posterior_log_variance = Draw(4, {kRows, kLatents}) * 0.5,
          .prior_mean = Draw(5, {kRows, kLatents}),
          .prior_log_variance = Draw(6, {kRows, kLatents}) * 0.5,
          .valid = Flags({1, 1, 0, 1, 1, 1, 1, 1, 1, 1, 1, 1}),
          .linked = Flags({0, 1, 0, 0, 0, 1, 0, 1, 0, 1, 1, 1})};
}

DistillationWeights Weights(v1::Distillation::Form form) {
  return {.form = form,
          .kl = 0.1,
          .continuity = 0.2,
          .row_scale = 1.0 / 11,
          .pair_scale = 1.0 / 6};
}

double At(const Tensor& tensor, int row, int column) {
  return tensor[row][column].item<double>();
}

// The formulas of the header, number by number.
struct ByHand {
  double action = 0, kl = 0, continuity = 0;
};

ByHand Compute(const DistillationTensors& t, bool paper) {
  ByHand sums;
  for (int row = 0; row < kRows; ++row) {
    double action = 0, kl = 0, step = 0;
    for (int a = 0; a < kActions; ++a) {
      action += std::pow(At(t.action, row, a) - At(t.label, row, a), 2);
    }
    for (int z = 0; z < kLatents; ++z) {
      const double s = std::exp(0.5 * At(t.posterior_log_variance, row, z));
      const double r = std::exp(0.5 * At(t.prior_log_variance, row, z));
      const double d = At(t.posterior_mean, row, z) - At(t.prior_mean, row, z);
      kl += std::log(r / s) + (s * s + d * d) / (2 * r * r) - 0.5;
      if (row == 0) continue;
      step +=
          std::pow(At(t.posterior_mean, row, z) -
                       (paper ? 1 : 0.99) * At(t.posterior_mean, row - 1, z),
                   2);
    }
    const double valid = t.valid[row].item<double>();
    sums.action += valid * (paper ? action : std::sqrt(action)) / 11;
    sums.kl += valid * kl / 11;
    sums.continuity +=
        t.linked[row].item<double>() * (paper ? step : std::sqrt(step)) / 6;
  }
  return sums;
}

class DistillationLossForms
    : public ::testing::TestWithParam<v1::Distillation::Form> {};

TEST_P(DistillationLossForms, AreTheFormulasNumberByNumber) {
  const DistillationTensors tensors = Tensors();
  const bool paper = GetParam() == v1::Distillation::FORM_PAPER;

  const DistillationTerms terms =
      DistillationLoss(tensors, kSteps, Weights(GetParam()));

  const ByHand expected = Compute(tensors, paper);
  EXPECT_NEAR(terms.action.item<double>(), expected.action, 1e-9);
  EXPECT_NEAR(terms.latent_kl.item<double>(), expected.kl, 1e-9);
  EXPECT_NEAR(terms.continuity.item<double>(), expected.continuity, 1e-9);
  EXPECT_NEAR(terms.loss.item<double>(),
              expected.action + 0.1 * expected.kl + 0.2 * expected.continuity,
              1e-9);
}

// d loss / d number against central differences, for every input.
TEST_P(DistillationLossForms, HaveTheGradientOfCentralDifferences) {
  DistillationTensors tensors = Tensors();
  const DistillationWeights weights = Weights(GetParam());
  const auto loss = [&] {
    return DistillationLoss(tensors, kSteps, weights).loss;
  };
  for (Tensor* input : {&tensors.action, &tensors.posterior_mean,
                        &tensors.posterior_log_variance, &tensors.prior_mean,
                        &tensors.prior_log_variance}) {
    const Tensor values = input->clone();
    *input = values.clone().set_requires_grad(true);
    const Tensor gradient = torch::autograd::grad({loss()}, {*input})[0];
    for (int64_t i = 0; i < values.numel(); ++i) {
      constexpr double kStep = 1e-5;
      double sides[2];
      for (int side = 0; side < 2; ++side) {
        *input = values.clone();
        input->view({-1})[i] += side == 0 ? kStep : -kStep;
        sides[side] = loss().item<double>();
      }
      EXPECT_NEAR(gradient.reshape({-1})[i].item<double>(),
                  (sides[0] - sides[1]) / (2 * kStep), 1e-7);
    }
    *input = values;
  }
}

TEST_P(DistillationLossForms, NeverCompareRowsAcrossACut) {
  DistillationTensors tensors = Tensors();
  const DistillationWeights weights = Weights(GetParam());
  const double before =
      DistillationLoss(tensors, kSteps, weights).continuity.item<double>();

  // Row 3 goes on from nothing, since row 2 is not valid, and nothing from it:
  // it is the last of its sequence.
  tensors.posterior_mean[3] += 100;

  EXPECT_EQ(
      DistillationLoss(tensors, kSteps, weights).continuity.item<double>(),
      before);
}

TEST_P(DistillationLossForms, HaveAFiniteGradientAtThePerfectStudent) {
  DistillationTensors tensors = Tensors();
  tensors.action = tensors.label.clone().set_requires_grad(true);

  const DistillationTerms terms =
      DistillationLoss(tensors, kSteps, Weights(GetParam()));
  const Tensor gradient =
      torch::autograd::grad({terms.loss}, {tensors.action})[0];

  EXPECT_EQ(gradient.abs().max().item<double>(), 0);
}

INSTANTIATE_TEST_SUITE_P(Forms, DistillationLossForms,
                         ::testing::Values(v1::Distillation::FORM_PAPER,
                                           v1::Distillation::FORM_CODE),
                         [](const auto& form) {
                           return form.param == v1::Distillation::FORM_PAPER
                                      ? "Paper"
                                      : "Code";
                         });

TEST(DistillationLoss, LimitsAHugeKlInsteadOfFollowingIt) {
  DistillationTensors tensors = Tensors();
  tensors.posterior_mean[1][0] = 1e6;
  tensors.posterior_mean =
      tensors.posterior_mean.clone().set_requires_grad(true);
  DistillationWeights weights = Weights(v1::Distillation::FORM_PAPER);
  weights.continuity = 0;

  const DistillationTerms terms = DistillationLoss(tensors, kSteps, weights);
  const Tensor gradient =
      torch::autograd::grad({terms.loss}, {tensors.posterior_mean})[0];

  EXPECT_LT(terms.latent_kl.item<double>(), 1e4);  // 1e5 / 11 and the others'
  EXPECT_EQ(gradient[1].abs().max().item<double>(), 0);
  EXPECT_GT(gradient[0].abs().max().item<double>(), 0);
}

TEST(DistillationLoss, IsTheActionsAloneWithoutALatent) {
  const DistillationTensors all = Tensors();
  const DistillationTensors plain = {.action = all.action,
                                     .label = all.label,
                                     .valid = all.valid,
                                     .linked = all.linked};

  const DistillationTerms terms =
      DistillationLoss(plain, kSteps, Weights(v1::Distillation::FORM_PAPER));

  EXPECT_NEAR(terms.loss.item<double>(), Compute(all, true).action, 1e-9);
  EXPECT_FALSE(terms.latent_kl.defined());
}

}  // namespace
}  // namespace sinew::learner
