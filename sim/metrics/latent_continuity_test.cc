#include "sim/metrics/latent_continuity.h"

#include <gtest/gtest.h>

#include <cmath>

namespace sinew::metrics {
namespace {

TEST(LatentContinuity, IsTheMeanStepAndTheSpread) {
  LatentMeter meter(2);

  // Steps of length 5 and 0; mean (2, 8/3).
  meter.AddMotion({0, 0, 3, 4, 3, 4});

  const LatentContinuity figures = meter.figures();
  EXPECT_EQ(figures.steps, 2);
  EXPECT_DOUBLE_EQ(figures.step, 2.5);
  // Mean square 50 / 3, less 4 + 64 / 9.
  EXPECT_NEAR(figures.spread, std::sqrt(50.0 / 3 - 4 - 64.0 / 9), 1e-12);
  EXPECT_NEAR(figures.ratio, figures.step / figures.spread, 1e-12);
}

TEST(LatentContinuity, TakesNoStepFromOneMotionToTheNext) {
  LatentMeter meter(1);

  meter.AddMotion({0, 0});
  meter.AddMotion({100, 100});

  EXPECT_EQ(meter.figures().steps, 2);
  EXPECT_EQ(meter.figures().step, 0);
  EXPECT_DOUBLE_EQ(meter.figures().spread, 50);
}

TEST(LatentContinuity, IsNothingWithoutMotions) {
  LatentMeter meter(3);

  meter.AddMotion({});

  EXPECT_EQ(meter.figures().steps, 0);
  EXPECT_EQ(meter.figures().spread, 0);
  EXPECT_EQ(meter.figures().ratio, 0);
}

}  // namespace
}  // namespace sinew::metrics
