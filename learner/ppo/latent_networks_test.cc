// Losses and gradients of a policy with a latent.

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <memory>
#include <numbers>
#include <numeric>
#include <string>
#include <vector>

#include "absl/strings/match.h"
#include "absl/types/span.h"
#include "common/config/recipe.h"
#include "common/policy/executor.h"
#include "common/policy/latent_builder.h"
#include "common/policy/safetensors.h"
#include "common/segment/segment_layout.h"
#include "common/testing/matchers.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "learner/ppo/batch.h"
#include "learner/ppo/ppo_networks.h"
#include "learner/ppo/synthetic_segments.h"
#include "learner/ppo/testing/latent_kl.h"
#include "learner/ppo/testing/networks_rig.h"
#include "learner/update/segment_view.h"

namespace sinew::learner {
namespace {

using ::sinew::testing::IsOk;

constexpr int kObservation = 6, kOwn = 4, kAction = 2, kLatent = 3;
constexpr double kClip = 0.2, kKlWeight = 0.5;

policy::LatentPolicyOptions NetworkOptions() {
  v1::Recipe recipe;
  v1::Network& network = *recipe.mutable_network();
  network.add_value_hidden(5);
  network.set_last_layer_gain(1);
  network.set_initial_std(0.3);
  v1::Latent& latent = *network.mutable_latent();
  latent.set_width(kLatent);
  latent.add_encoder_hidden(7);
  latent.add_prior_hidden(7);
  latent.add_decoder_hidden(7);
  return {.self_observation_width = kOwn,
          .observation_width = kObservation,
          .action_width = kAction,
          .network = WithDefaults(recipe).network(),
          .explores = true};
}

// Initial weights whose normalisers know the synthetic observations.
TensorMap InitialWeights() {
  TensorMap weights = *policy::InitialLatentWeights(NetworkOptions(), 3);
  for (auto& [name, tensor] : weights) {
    if (!absl::StartsWith(name, "normaliser/")) continue;
    const float value = absl::EndsWith(name, "/mean") ? 3.0F : 0.5F;
    for (float& element : tensor.mutable_float32()) element = value;
  }
  return weights;
}

// Networks that have moved on from those that acted, and a batch.
struct Fixture {
  explicit Fixture(double ratio_clip, double kl_weight = kKlWeight)
      : segments(MakeSyntheticSegments({.observation_width = kObservation,
                                        .action_width = kAction,
                                        .latent_width = kLatent,
                                        .orders = 2,
                                        .environments = 4,
                                        .steps = 8,
                                        .invalid_share = 0.1},
                                       graph, weights, 0)) {
    MoveOn(
        0.02F,
        [](const std::string& name) {
          return absl::EndsWith(name, "/weight") ||
                 absl::EndsWith(name, "/bias");
        },
        weights);
    networks = *PpoNetworks::Create(
        graph, weights,
        {.shards = 2, .ratio_clip = ratio_clip, .latent_kl_weight = kl_weight});
    Load();
  }

  void Load() {
    figures = LoadBatch(segments, batch, *networks);
    rows.resize(batch.rows());
    std::iota(rows.begin(), rows.end(), 0);
  }

  double scale() const { return 1 / static_cast<double>(figures.valid_rows); }

  const v1::PolicyGraph graph = *policy::BuildLatentPolicy(NetworkOptions());
  TensorMap weights = InitialWeights();
  const std::vector<v1::Segment> segments;
  std::unique_ptr<PpoNetworks> networks;
  Batch batch{
      kAction,
      MakeSegmentLayout(kObservation, kAction, /*distillation=*/false, kLatent),
      0.9, 0.95};
  BatchFigures figures;
  std::vector<int64_t> rows;
};

// Means of the policy for all rows, by the Eigen executor.
std::vector<float> Means(const Fixture& f) {
  const auto pack = policy::PackWeights(f.graph, "policy", f.weights);
  const auto executor = *policy::Executor::Create(*pack, 1);
  const auto input = [&](const char* name) {
    return executor->input(executor->input_index(name)).begin();
  };
  std::vector<float> values;
  for (int s = 0; s < f.batch.num_segments(); ++s) {
    const SegmentView& view = f.batch.view(s);
    for (int64_t row = 0; row < view.rows(); ++row) {
      std::copy_n(&view.observation[row * kObservation], kObservation,
                  input("observation"));
      std::copy_n(&view.latent_noise[row * kLatent], kLatent, input("noise"));
      executor->Run(1);
      const auto found = executor->tap(executor->tap_index("mean"));
      values.insert(values.end(), found.begin(), found.end());
    }
  }
  return values;
}

// The objective given the latent's noise, in double, row by row.
struct Objective {
  double loss = 0, kl = 0, clipped = 0, latent_kl = 0;
};

Objective EvaluateObjective(const Fixture& f) {
  const std::vector<float> means = Means(f);
  std::vector<double> latent_kl;
  for (int s = 0; s < f.batch.num_segments(); ++s) {
    const std::vector<double> part = LatentKl(
        f.graph, f.weights, f.batch.view(s).observation, kObservation, kOwn);
    latent_kl.insert(latent_kl.end(), part.begin(), part.end());
  }
  const float* std = f.weights.at("policy/std").float32().data();
  Objective result;
  for (int64_t row = 0; row < f.batch.rows(); ++row) {
    double log_p = 0, kl = 0;
    for (int a = 0; a < kAction; ++a) {
      const int64_t i = row * kAction + a;
      const double z = (f.batch.action()[i] - means[i]) / std[a];
      log_p -=
          0.5 * z * z + std::log(std[a]) + 0.5 * std::log(2 * std::numbers::pi);
      const double drift = (means[i] - f.batch.action_mean()[i]) / std[a];
      kl += 0.5 * drift * drift;
    }
    const double ratio = std::exp(
        std::clamp(log_p - f.batch.log_probability()[row], -20.0, 20.0));
    const double a = f.batch.advantage()[row];
    const double w = f.batch.weight()[row];
    result.loss -=
        w * f.scale() *
        std::min(ratio * a, std::clamp(ratio, 1 - kClip, 1 + kClip) * a);
    result.loss += w * f.scale() * kKlWeight * latent_kl[row];
    result.kl += w * kl;
    result.clipped += w * (std::abs(ratio - 1) > kClip);
    result.latent_kl += w * latent_kl[row];
  }
  return result;
}

TEST(LatentNetworks, TheLossIsTheClippedObjectiveAndTheWeighedKl) {
  Fixture f(kClip);
  const Objective expected = EvaluateObjective(f);

  const auto found = f.networks->PolicyFigures(f.rows, f.scale());

  ASSERT_THAT(found, IsOk());
  EXPECT_NEAR(found->loss, expected.loss,
              1e-4 + 1e-4 * std::abs(expected.loss));
  EXPECT_NEAR(found->kl, expected.kl, 1e-3 * expected.kl);
  EXPECT_NEAR(found->latent_kl, expected.latent_kl, 1e-4 * expected.latent_kl);
  // A row may lie on the very edge.
  EXPECT_NEAR(found->clipped, expected.clipped, 1);
  EXPECT_GT(expected.clipped, 1);
  EXPECT_GT(expected.latent_kl * f.scale(), 0.01);
}

// The gradient of the policy's parameters, summed over two shards.
TensorMap GradientOf(Fixture& f) {
  const absl::Span<const int64_t> all = f.rows;
  const size_t half = all.size() / 2;
  for (const int shard : {0, 1}) {
    EXPECT_THAT(
        f.networks->Gradient(NetworkId::kPolicy, shard,
                             all.subspan(shard * half, half), f.scale()),
        IsOk());
  }
  EXPECT_THAT(f.networks->SumGradients(NetworkId::kPolicy), IsOk());
  // Adam's first moment after a step is a tenth of the gradient.
  EXPECT_THAT(f.networks->Step(NetworkId::kPolicy, /*learning_rate=*/0, 1),
              IsOk());
  TensorMap moments, gradient;
  f.networks->SaveOptimiser(NetworkId::kPolicy, moments);
  const std::string prefix = "adam/first_moment/";
  for (const auto& [name, moment] : moments) {
    if (!absl::StartsWith(name, prefix)) continue;
    HostTensor& tensor = gradient[name.substr(prefix.size())] = moment;
    for (float& element : tensor.mutable_float32()) element *= 10;
  }
  return gradient;
}

double Norm(const HostTensor& tensor) {
  double squares = 0;
  for (const float value : tensor.float32()) squares += value * value;
  return std::sqrt(squares);
}

// Of each parameter tensor, the slope along its own gradient is the gradient's
// norm: central differences of the loss.
TEST(LatentNetworks, GradientsAreTheSlopesOfTheLoss) {
  // Nothing is clipped: a kink has no slope.
  Fixture f(/*ratio_clip=*/100);
  const TensorMap gradient = GradientOf(f);
  for (const char* name : {"encoder/mean/weight", "encoder/log_variance/weight",
                           "prior/mean/weight", "prior/log_variance/weight",
                           "decoder/action/weight"}) {
    ASSERT_TRUE(gradient.contains(name)) << name;
    EXPECT_GT(Norm(gradient.at(name)), 0.01) << name;
  }
  for (const auto& [name, tensor] : gradient) {
    const double norm = Norm(tensor);
    ASSERT_TRUE(std::isfinite(norm)) << name;
    if (norm < 0.01) continue;
    // Rounding is 1e-6 / 1e-2, curvature less.
    constexpr double kStep = 5e-3;
    double sides[2];
    for (int side = 0; side < 2; ++side) {
      TensorMap moved = f.weights;
      for (int64_t i = 0; i < tensor.num_elements(); ++i) {
        moved.at(name).mutable_float32()[i] += static_cast<float>(
            (side == 0 ? kStep : -kStep) * tensor.float32()[i] / norm);
      }
      ASSERT_THAT(f.networks->LoadWeights(moved), IsOk());
      sides[side] = f.networks->PolicyFigures(f.rows, f.scale())->loss;
    }
    EXPECT_NEAR((sides[0] - sides[1]) / (2 * kStep), norm, 0.02 * norm + 2e-3)
        << name;
  }
}

TEST(LatentNetworks, ThePriorLearnsFromTheKlAlone) {
  Fixture f(kClip, /*kl_weight=*/0);

  for (const auto& [name, tensor] : GradientOf(f)) {
    if (absl::StartsWith(name, "prior/")) EXPECT_EQ(Norm(tensor), 0) << name;
    if (absl::EndsWith(name, "/weight") && !absl::StartsWith(name, "prior/")) {
      EXPECT_GT(Norm(tensor), 0) << name;
    }
    EXPECT_FALSE(absl::StartsWith(name, "critic/")) << name;
  }
}

}  // namespace
}  // namespace sinew::learner
