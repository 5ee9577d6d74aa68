#include "learner/ppo/ppo_networks.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <memory>
#include <numbers>
#include <numeric>
#include <string>
#include <vector>

#include "common/config/recipe.h"
#include "common/policy/builder.h"
#include "common/policy/executor.h"
#include "common/segment/segment_layout.h"
#include "common/testing/matchers.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "learner/ppo/batch.h"
#include "learner/ppo/synthetic_segments.h"
#include "learner/ppo/testing/networks_rig.h"

namespace sinew::learner {
namespace {

using ::sinew::testing::IsOk;

constexpr int kObservation = 4, kAction = 2;
constexpr double kClip = 0.2, kEntropyWeight = 0.01;

policy::TrackingPolicyOptions NetworkOptions() {
  v1::Recipe recipe;
  recipe.mutable_network()->add_policy_hidden(5);
  recipe.mutable_network()->add_value_hidden(5);
  recipe.mutable_network()->set_last_layer_gain(1);
  recipe.mutable_network()->set_initial_std(0.3);
  return {.observation_width = kObservation,
          .action_width = kAction,
          .network = WithDefaults(recipe).network()};
}

// Networks that have moved on from those that acted, and a batch.
struct Fixture {
  explicit Fixture(double ratio_clip = kClip) {
    const auto options = NetworkOptions();
    graph = *policy::BuildTrackingPolicy(options);
    weights = *policy::InitialWeights(options, 3);
    segments = MakeSyntheticSegments({.observation_width = kObservation,
                                      .action_width = kAction,
                                      .orders = 2,
                                      .environments = 4,
                                      .steps = 8,
                                      .invalid_share = 0.1},
                                     graph, weights, 0);
    MoveOn(
        0.015f,
        [](const std::string& name) {
          return name.find("linear") != std::string::npos ||
                 name.find("mean/") != std::string::npos;
        },
        weights);
    networks = *PpoNetworks::Create(graph, weights,
                                    {.shards = 2,
                                     .ratio_clip = ratio_clip,
                                     .entropy_weight = kEntropyWeight});
    Load();
  }

  void Load() {
    figures = LoadBatch(segments, batch, *networks);
    // The batch has scaled its own to sums of rewards.
    values.resize(batch.rows() + batch.bootstrap_rows());
    ASSERT_THAT(networks->Values(0, absl::MakeSpan(values)), IsOk());
    rows.resize(batch.rows());
    std::iota(rows.begin(), rows.end(), 0);
  }

  double scale() const { return 1 / static_cast<double>(figures.valid_rows); }

  v1::PolicyGraph graph;
  TensorMap weights;
  std::vector<v1::Segment> segments;
  std::unique_ptr<PpoNetworks> networks;
  Batch batch{kAction, MakeSegmentLayout(kObservation, kAction), 0.9, 0.95};
  BatchFigures figures;
  std::vector<float> values;
  std::vector<int64_t> rows;
};

// Means of all rows by the Eigen executor: [rows, A].
std::vector<float> Means(const Fixture& f) {
  const auto pack = policy::PackWeights(f.graph, "policy", f.weights);
  auto executor = *policy::Executor::Create(*pack, 1);
  std::vector<float> means;
  for (int s = 0; s < f.batch.num_segments(); ++s) {
    const auto observations = f.batch.view(s).observation;
    for (size_t i = 0; i < observations.size(); i += kObservation) {
      std::copy_n(
          &observations[i], kObservation,
          executor->input(executor->input_index("observation")).begin());
      executor->Run(1);
      const auto mean = executor->tap(executor->tap_index("mean"));
      means.insert(means.end(), mean.begin(), mean.begin() + kAction);
    }
  }
  return means;
}

// The objective of Schulman et al. 2017, equation 7, in double, row by row.
struct Objective {
  double loss = 0, kl = 0, clipped = 0, entropy = 0;
  std::vector<double> ratios;
};

Objective EvaluateObjective(const Fixture& f) {
  const std::vector<float> means = Means(f);
  const float* std = f.weights.at("policy/std").float32().data();
  Objective result;
  for (int64_t row = 0; row < f.batch.rows(); ++row) {
    double log_p = 0, kl = 0, entropy = 0;
    for (int a = 0; a < kAction; ++a) {
      const int64_t i = row * kAction + a;
      const double z = (f.batch.action()[i] - means[i]) / std[a];
      const double log_norm =
          std::log(std[a]) + 0.5 * std::log(2 * std::numbers::pi);
      log_p -= 0.5 * z * z + log_norm;
      const double drift = (means[i] - f.batch.action_mean()[i]) / std[a];
      kl += 0.5 * drift * drift;
      entropy += log_norm + 0.5;
    }
    const double ratio = std::exp(log_p - f.batch.log_probability()[row]);
    const double a = f.batch.advantage()[row];
    const double w = f.batch.weight()[row];
    result.ratios.push_back(ratio);
    result.loss -=
        w * f.scale() *
        std::min(ratio * a, std::clamp(ratio, 1 - kClip, 1 + kClip) * a);
    result.loss -= w * f.scale() * kEntropyWeight * entropy;
    result.kl += w * kl;
    result.clipped += w * (std::abs(ratio - 1) > kClip);
    result.entropy += w * entropy;
  }
  return result;
}

TEST(PpoNetworks, TheLossIsTheClippedObjective) {
  Fixture f;
  const Objective expected = EvaluateObjective(f);

  const auto found = f.networks->PolicyFigures(f.rows, f.scale());

  ASSERT_THAT(found, IsOk());
  EXPECT_NEAR(found->loss, expected.loss, 1e-5);
  EXPECT_NEAR(found->kl, expected.kl, 1e-4 * expected.kl);
  EXPECT_NEAR(found->entropy, expected.entropy, 1e-4);
  EXPECT_EQ(found->clipped, expected.clipped);
  // The batch has both kinds of rows.
  EXPECT_GT(expected.clipped, 5);
  EXPECT_LT(expected.clipped, static_cast<double>(f.rows.size()) - 5);
}

TEST(PpoNetworks, TheValueLossIsHalfTheMeanSquaredError) {
  Fixture f;
  double expected = 0;
  for (const int64_t row : f.rows) {
    const double error = f.values[row] - f.batch.value_target()[row];
    expected += f.batch.weight()[row] * error * error / 2 * f.scale();
  }

  const auto found =
      f.networks->Gradient(NetworkId::kValue, 0, f.rows, f.scale());

  ASSERT_THAT(found, IsOk());
  EXPECT_NEAR(found->loss, expected, 1e-5 * expected);
}

TEST(PpoNetworks, ARowBeyondTheClipPullsBackOnly) {
  Fixture f;
  const std::vector<double> ratios = EvaluateObjective(f).ratios;
  const auto norm_of = [&f](int64_t row) {
    EXPECT_THAT(f.networks->Gradient(NetworkId::kPolicy, 0, {&row, 1}, 1),
                IsOk());
    // The other shard has no part in this.
    EXPECT_THAT(f.networks->Gradient(NetworkId::kPolicy, 1, {}, 1), IsOk());
    return f.networks->SumGradients(NetworkId::kPolicy).value();
  };

  int beyond = 0, back = 0;
  for (const int64_t row : f.rows) {
    if (f.batch.weight()[row] == 0) continue;
    const double a = f.batch.advantage()[row];
    // A hair of room for float32.
    const bool above = ratios[row] > 1 + kClip + 1e-4;
    const bool below = ratios[row] < 1 - kClip - 1e-4;
    if ((above && a > 0) || (below && a < 0)) {
      EXPECT_EQ(norm_of(row), 0) << row;
      ++beyond;
    } else if (above || below) {
      EXPECT_GT(norm_of(row), 0) << row;
      ++back;
    }
  }
  EXPECT_GT(beyond, 0);
  EXPECT_GT(back, 0);
}

// Every element of both gradients, summed over two shards, against central
// differences of the loss.
TEST(PpoNetworks, GradientsAreTheSlopesOfTheLosses) {
  // Nothing is clipped: a kink has no slope (the test above is about it).
  Fixture f(/*ratio_clip=*/100);
  const absl::Span<const int64_t> all = f.rows;
  const size_t half = all.size() / 2;
  for (const NetworkId network : {NetworkId::kPolicy, NetworkId::kValue}) {
    const auto loss = [&](const TensorMap& weights) {
      EXPECT_THAT(f.networks->LoadWeights(weights), IsOk());
      return f.networks->Gradient(network, 0, all, f.scale())->loss;
    };
    ASSERT_THAT(f.networks->LoadWeights(f.weights), IsOk());
    for (const int shard : {0, 1}) {
      ASSERT_THAT(
          f.networks->Gradient(network, shard, all.subspan(shard * half, half),
                               f.scale()),
          IsOk());
    }
    ASSERT_THAT(f.networks->SumGradients(network), IsOk());
    // Adam's first moment after a step is a tenth of the gradient.
    ASSERT_THAT(f.networks->Step(network, /*learning_rate=*/0, 1), IsOk());
    TensorMap moments;
    f.networks->SaveOptimiser(network, moments);

    int elements = 0;
    for (const auto& [name, moment] : moments) {
      if (name.find("first_moment/") == std::string::npos) continue;
      const std::string parameter =
          name.substr(std::string("adam/first_moment/").size());
      for (int64_t i = 0; i < moment.num_elements(); ++i, ++elements) {
        constexpr float kStep = 2e-3f;
        TensorMap up = f.weights, down = f.weights;
        up.at(parameter).mutable_float32()[i] += kStep;
        down.at(parameter).mutable_float32()[i] -= kStep;
        const double slope = (loss(up) - loss(down)) / (2 * kStep);
        EXPECT_NEAR(10 * moment.float32()[i], slope,
                    0.004 + 0.02 * std::abs(slope))
            << parameter << " " << i;
      }
    }
    // 4 x 5 + 5 + 5 x 2 + 2 and 4 x 5 + 5 + 5 + 1.
    EXPECT_EQ(elements, network == NetworkId::kPolicy ? 37 : 31);
  }
}

}  // namespace
}  // namespace sinew::learner
