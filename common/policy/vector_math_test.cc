#include "common/policy/vector_math.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

#include "gtest/gtest.h"

namespace sinew::policy::internal {
namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();

// Largest error of f against `exact` in units in the last place of the exact
// result, over `steps` numbers spread evenly from low to high. Results below
// the smallest normal number are measured in units of its last place.
template <typename F, typename Exact>
double WorstUlps(F f, Exact exact, double low, double high, int steps) {
  double worst = 0;
  for (int i = 0; i <= steps; ++i) {
    const float x = static_cast<float>(low + (high - low) * i / steps);
    const double expected = exact(static_cast<double>(x));
    int exponent = 0;
    std::frexp(expected, &exponent);
    const double ulp = std::ldexp(1.0, std::max(exponent, -125) - 24);
    const double error = std::abs(f(Splat(x))[i % kLanes] - expected) / ulp;
    worst = std::max(worst, error);
  }
  return worst;
}

double ExactSigmoid(double x) { return 1 / (1 + std::exp(-x)); }
double ExactSilu(double x) { return x * ExactSigmoid(x); }
double ExactElu(double x) { return x > 0 ? x : std::expm1(x); }

constexpr int kSteps = 400'000;

TEST(VectorMath, ExpIsAsExactAsItSays) {
  const auto exact = [](double x) { return std::exp(x); };
  EXPECT_LT(WorstUlps(Exp, exact, -87, 88.7, kSteps), 1.5);
  EXPECT_LT(WorstUlps(Exp, exact, -1, 1, kSteps), 1.5);
  EXPECT_LT(WorstUlps(Exp, exact, -104, -87, kSteps), 1.5);
}

TEST(VectorMath, Expm1IsAsExactAsItSays) {
  const auto exact = [](double x) { return std::expm1(x); };
  EXPECT_LT(WorstUlps(Expm1, exact, -30, 80, kSteps), 2);
  EXPECT_LT(WorstUlps(Expm1, exact, -2, 2, kSteps), 2);
  EXPECT_LT(WorstUlps(Expm1, exact, -1e-6, 1e-6, kSteps), 2);
}

TEST(VectorMath, SigmoidIsAsExactAsItSays) {
  EXPECT_LT(WorstUlps(Sigmoid, ExactSigmoid, -87, 87, kSteps), 3);
  EXPECT_LT(WorstUlps(Sigmoid, ExactSigmoid, -4, 4, kSteps), 3);
}

TEST(VectorMath, SiluIsAsExactAsItSays) {
  EXPECT_LT(WorstUlps(Silu, ExactSilu, -87, 100, kSteps), 3);
  EXPECT_LT(WorstUlps(Silu, ExactSilu, -4, 4, kSteps), 3);
}

TEST(VectorMath, EluIsAsExactAsItSays) {
  EXPECT_LT(WorstUlps(Elu, ExactElu, -40, 10, kSteps), 2);
  EXPECT_LT(WorstUlps(Elu, ExactElu, -1e-4, 1e-4, kSteps), 2);
}

TEST(VectorMath, TanhIsAsExactAsItSays) {
  const auto exact = [](double x) { return std::tanh(x); };
  EXPECT_LT(WorstUlps(Tanh, exact, -12, 12, kSteps), 4);
  EXPECT_LT(WorstUlps(Tanh, exact, -0.7, 0.7, kSteps), 4);
  EXPECT_LT(WorstUlps(Tanh, exact, -1e-5, 1e-5, kSteps), 4);
}

TEST(VectorMath, ReachesTheLimitsBeyondTheRange) {
  EXPECT_EQ(Exp(Splat(89.0f))[0], kInfinity);
  EXPECT_EQ(Exp(Splat(kInfinity))[0], kInfinity);
  EXPECT_EQ(Exp(Splat(-1000.0f))[0], 0.0f);
  EXPECT_EQ(Exp(Splat(-kInfinity))[0], 0.0f);
  EXPECT_EQ(Sigmoid(Splat(-1000.0f))[0], 0.0f);
  EXPECT_EQ(Sigmoid(Splat(1000.0f))[0], 1.0f);
  EXPECT_EQ(Silu(Splat(-1000.0f))[0], 0.0f);
  EXPECT_EQ(Silu(Splat(1000.0f))[0], 1000.0f);
  EXPECT_EQ(Elu(Splat(-kInfinity))[0], -1.0f);
  EXPECT_EQ(Elu(Splat(kInfinity))[0], kInfinity);
  EXPECT_EQ(Tanh(Splat(kInfinity))[0], 1.0f);
  EXPECT_EQ(Tanh(Splat(-kInfinity))[0], -1.0f);
}

TEST(VectorMath, KeepsZeroItsSign) {
  EXPECT_EQ(Exp(Splat(0.0f))[0], 1.0f);
  EXPECT_TRUE(std::signbit(Tanh(Splat(-0.0f))[0]));
  EXPECT_EQ(Tanh(Splat(0.0f))[0], 0.0f);
  EXPECT_EQ(Elu(Splat(0.0f))[0], 0.0f);
}

TEST(VectorMath, TurnsNanIntoNan) {
  const Float8 nan = Splat(std::numeric_limits<float>::quiet_NaN());
  for (const auto f : {Exp, Expm1, Sigmoid, Silu, Elu, Tanh}) {
    EXPECT_TRUE(std::isnan(f(nan)[3]));
  }
  EXPECT_TRUE(std::isnan(Clamp(nan, -1.0f, 1.0f)[0]));
}

TEST(VectorMath, GivesTheSameBitsInEveryLane) {
  for (const auto f : {Exp, Expm1, Sigmoid, Silu, Elu, Tanh}) {
    for (int i = 0; i < 1000; ++i) {
      const float x = -5.0f + 0.01f * static_cast<float>(i);
      Float8 mixed = {9, -9, 0.5f, -0.5f, 80, -80, 1e-9f, 0};
      const int lane = i % kLanes;
      mixed[lane] = x;
      const float alone = f(Splat(x))[0];
      const float among = f(mixed)[lane];
      ASSERT_EQ(std::memcmp(&alone, &among, sizeof(alone)), 0) << x;
    }
  }
}

TEST(VectorMath, KeepsTheFirstLanesOnly) {
  const Float8 kept = Keep(Splat(2.0f), 3, -1.0f);

  EXPECT_EQ(Sum(kept), 3 * 2.0f - 5 * 1.0f);
  EXPECT_EQ(Max(Keep(Splat(2.0f), 0, -1.0f)), -1.0f);
  EXPECT_EQ(Sum(Keep(Splat(2.0f), 100, 0.0f)), 16.0f);
}

}  // namespace
}  // namespace sinew::policy::internal
