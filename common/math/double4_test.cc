#include "common/math/double4.h"

#include <cmath>
#include <cstring>
#include <limits>

#include "gtest/gtest.h"

namespace sinew {
namespace {

constexpr int kSteps = 400'000;

// Calls f(number, its lane) for numbers spread evenly from low to high.
template <typename F>
void ForNumbers(double low, double high, F f) {
  for (int i = 0; i <= kSteps; ++i) f(low + (high - low) * i / kSteps, i % 4);
}

// The largest of errors; NaN if one of them is, which passes no bound.
class Worst {
 public:
  void Add(double error) {
    if (!(error <= value_)) value_ = std::isnan(value_) ? value_ : error;
  }
  double value() const { return value_; }

 private:
  double value_ = 0;
};

TEST(SinCos, AreAsExactAsTheySay) {
  for (const double range : {0.8, 4.0, 1000.0, 1e6}) {
    Worst worst;
    ForNumbers(-range, range, [&](double x, int lane) {
      const SinCos4 found = SinCos(Splat4(x));
      worst.Add(std::abs(found.sin[lane] - std::sin(x)));
      worst.Add(std::abs(found.cos[lane] - std::cos(x)));
    });
    EXPECT_LT(worst.value(), 1e-15) << range;
  }
}

TEST(SinCos, KeepsSmallAngles) {
  EXPECT_EQ(SinCos(Splat4(1e-200)).sin[0], 1e-200);
  EXPECT_EQ(SinCos(Splat4(0)).cos[0], 1);
}

TEST(AngleOf, IsAsExactAsItSaysAllOverTheQuadrant) {
  Worst worst;
  ForNumbers(0, 1.5707963, [&](double angle, int lane) {
    const double x = 0.7 * std::cos(angle);
    const double y = 0.7 * std::sin(angle);
    const double exact = std::atan2(y, x);
    const double error = std::abs(AngleOf(Splat4(x), Splat4(y))[lane] - exact);
    worst.Add(exact == 0 ? error : error / exact);
  });
  EXPECT_LT(worst.value(), 4e-14);
}

TEST(AngleOf, KeepsItsEnds) {
  EXPECT_EQ(AngleOf(Splat4(1), Splat4(0))[1], 0);
  EXPECT_EQ(AngleOf(Splat4(1), Splat4(1e-200))[1], 1e-200);
  EXPECT_EQ(AngleOf(Splat4(0), Splat4(1))[1], std::numbers::pi / 2);
}

TEST(Double4, TurnsNanIntoNan) {
  const Double4 nan = Splat4(std::numeric_limits<double>::quiet_NaN());

  EXPECT_TRUE(std::isnan(SinCos(nan).sin[0]));
  EXPECT_TRUE(std::isnan(SinCos(nan).cos[3]));
  EXPECT_TRUE(std::isnan(AngleOf(nan, Splat4(1))[2]));
  EXPECT_TRUE(std::isnan(AngleOf(Splat4(1), nan)[2]));
}

TEST(Double4, GivesTheSameBitsInEveryLane) {
  for (int i = 0; i < 4000; ++i) {
    const double x = -5 + 0.01 * i;
    Double4 mixed = {9, -0.5, 1e-9, 0};
    mixed[i % 4] = x;

    const double alone = SinCos(Splat4(x)).sin[0];
    const double among = SinCos(mixed).sin[i % 4];
    ASSERT_EQ(std::memcmp(&alone, &among, sizeof alone), 0) << x;
    const double angle = AngleOf(Splat4(1), Splat4(x * x))[0];
    const double angle_among = AngleOf(Splat4(1), mixed * mixed)[i % 4];
    ASSERT_EQ(std::memcmp(&angle, &angle_among, sizeof angle), 0) << x;
  }
}

}  // namespace
}  // namespace sinew
