#include "learner/ppo/gae.h"

#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

#include "common/random/philox.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace sinew::learner {
namespace {

using ::testing::Each;
using ::testing::FloatNear;

struct Problem {
  int64_t steps, environments;
  std::vector<float> rewards, values, next_values;
  std::vector<uint8_t> terminated, truncated;
  std::vector<float> advantages, returns;

  Problem(int64_t t, int64_t e)
      : steps(t),
        environments(e),
        rewards(t * e),
        values(t * e),
        next_values(t * e),
        terminated(t * e),
        truncated(t * e),
        advantages(t * e),
        returns(t * e) {}

  void Solve(double discount, double lambda) {
    ComputeGae({steps, environments, rewards, values, next_values, terminated,
                truncated},
               discount, lambda, absl::MakeSpan(advantages),
               absl::MakeSpan(returns));
  }
};

Problem RandomProblem(int64_t steps, int64_t environments, uint64_t seed) {
  Problem problem(steps, environments);
  std::vector<float> uniform(steps * environments);
  FillUniform({.seed = seed, .step = 0}, absl::MakeSpan(problem.rewards));
  FillNormal({.seed = seed, .step = 1}, absl::MakeSpan(problem.values));
  FillNormal({.seed = seed, .step = 2}, absl::MakeSpan(problem.next_values));
  FillUniform({.seed = seed, .step = 3}, absl::MakeSpan(uniform));
  for (size_t i = 0; i < uniform.size(); ++i) {
    problem.terminated[i] = uniform[i] < 0.1f;
    problem.truncated[i] = uniform[i] > 0.9f;
  }
  return problem;
}

// The definition, forwards: A_t = sum over k of (gamma lambda)^k delta_{t+k},
// up to and with the step that ends the episode or the grid.
double AdvantageByDefinition(const Problem& p, int64_t t, int64_t e,
                             double discount, double lambda) {
  double sum = 0, weight = 1;
  for (int64_t s = t; s < p.steps; ++s) {
    const int64_t i = s * p.environments + e;
    const double next = p.terminated[i] ? 0.0 : p.next_values[i];
    sum += weight * (p.rewards[i] + discount * next - p.values[i]);
    if (p.terminated[i] || p.truncated[i]) break;
    weight *= discount * lambda;
  }
  return sum;
}

TEST(Gae, EqualsTheSumOfItsDefinition) {
  for (uint64_t seed = 1; seed <= 5; ++seed) {
    Problem p = RandomProblem(/*steps=*/37, /*environments=*/5, seed);

    p.Solve(/*discount=*/0.97, /*lambda=*/0.9);

    for (int64_t t = 0; t < p.steps; ++t) {
      for (int64_t e = 0; e < p.environments; ++e) {
        const int64_t i = t * p.environments + e;
        const double expected = AdvantageByDefinition(p, t, e, 0.97, 0.9);
        EXPECT_NEAR(p.advantages[i], expected, 1e-5) << t << ", " << e;
        EXPECT_NEAR(p.returns[i], expected + p.values[i], 1e-5);
      }
    }
  }
}

TEST(Gae, LambdaOneGivesTheDiscountedReturn) {
  Problem p(/*t=*/50, /*e=*/1);
  for (float& reward : p.rewards) reward = 1;
  for (size_t i = 0; i < p.values.size(); ++i) p.values[i] = 0.3f * i;
  for (size_t i = 0; i + 1 < p.values.size(); ++i) {
    p.next_values[i] = p.values[i + 1];
  }
  p.terminated.back() = 1;

  p.Solve(/*discount=*/0.9, /*lambda=*/1);

  // The values cancel: R_t = (1 - 0.9^(50 - t)) / (1 - 0.9).
  for (int t = 0; t < 50; ++t) {
    EXPECT_NEAR(p.returns[t], 10 * (1 - std::pow(0.9, 50 - t)), 1e-4) << t;
  }
}

TEST(Gae, LambdaZeroLooksOneStepAhead) {
  Problem p = RandomProblem(10, 3, 9);

  p.Solve(0.95, 0);

  for (size_t i = 0; i < p.values.size(); ++i) {
    const double next = p.terminated[i] ? 0 : p.next_values[i];
    EXPECT_NEAR(p.returns[i], p.rewards[i] + 0.95 * next, 1e-6);
  }
}

TEST(Gae, ATrueValueFunctionHasNoAdvantage) {
  Problem p(20, 2);
  for (float& reward : p.rewards) reward = 2;
  for (float& value : p.values) value = 40;  // 2 / (1 - 0.95)
  p.next_values = p.values;

  p.Solve(0.95, 0.95);

  EXPECT_THAT(p.advantages, Each(FloatNear(0, 1e-5)));
}

TEST(Gae, TerminationHasNoValueBehindItAndTruncationHas) {
  Problem p(1, 3);
  p.rewards = {1, 1, 1};
  p.values = {0, 0, 0};
  p.next_values = {10, 10, 10};
  p.terminated = {1, 0, 0};
  p.truncated = {0, 1, 0};  // the third one is cut by the grid's end

  p.Solve(0.5, 0.95);

  EXPECT_THAT(p.returns, ::testing::ElementsAre(1, 6, 6));
}

TEST(Gae, NothingCrossesTheEndOfAnEpisode) {
  Problem p(3, 2);
  p.terminated = {0, 0, 1, 0, 0, 0};
  p.truncated = {0, 0, 0, 1, 0, 0};
  p.rewards = {0, 0, 0, 0, 100, 100};

  p.Solve(0.9, 0.9);

  EXPECT_THAT(p.advantages, ::testing::ElementsAre(0, 0, 0, 0, 100, 100));
}

TEST(Gae, NanStaysInItsOwnTrace) {
  Problem p(4, 2);
  p.rewards[1 * 2 + 0] = std::numeric_limits<float>::quiet_NaN();

  p.Solve(0.9, 0.9);

  EXPECT_TRUE(std::isnan(p.advantages[0]));
  EXPECT_TRUE(std::isnan(p.advantages[2]));
  for (int i : {1, 3, 4, 5, 6, 7}) EXPECT_EQ(p.advantages[i], 0) << i;
}

TEST(NextValues, ComeFromTheNextRowTheBoundaryAndTheTruncations) {
  const std::vector<float> values = {1, 2, 3, 4, 5, 6};  // [3, 2]
  std::vector<float> next(6);

  FillNextValues(values, {7, 8}, {1, 4}, {20, 50}, absl::MakeSpan(next));

  EXPECT_THAT(next, ::testing::ElementsAre(3, 20, 5, 6, 50, 8));
}

}  // namespace
}  // namespace sinew::learner
