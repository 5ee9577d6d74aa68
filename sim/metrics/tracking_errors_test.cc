#include "sim/metrics/tracking_errors.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <vector>

namespace sinew::metrics {
namespace {

using ::testing::DoubleNear;
using ::testing::ElementsAre;

using Positions = std::vector<Eigen::Vector3d>;

// Root at the origin, a second body at (0, 0, 1).
const Positions kReference = {{0, 0, 0}, {0, 0, 1}};

Positions Moved(double root_x, double second_x) {
  return {{root_x, 0, 0}, {second_x, 0, 1}};
}

TEST(TrackingErrors, AreZeroForThePerfectBody) {
  TrackingErrors errors(2, 30);

  for (int i = 0; i < 3; ++i) EXPECT_EQ(errors.Add(kReference, kReference), 0);

  EXPECT_EQ(errors.sums().frames, 3);
  EXPECT_EQ(errors.sums().g_mpjpe_mm, 0);
  EXPECT_EQ(errors.sums().mpjpe_mm, 0);
  EXPECT_EQ(errors.sums().velocity, 0);
  EXPECT_EQ(errors.sums().acceleration, 0);
}

TEST(TrackingErrors, TakeTheMeanOverBodies) {
  TrackingErrors errors(2, 30);

  // Errors 10 mm and 30 mm: mean 20 mm; relative to the root 0 and 20: 10 mm.
  EXPECT_DOUBLE_EQ(errors.Add(Moved(0.01, 0.03), kReference), 0.02);

  EXPECT_DOUBLE_EQ(errors.sums().g_mpjpe_mm, 20);
  EXPECT_DOUBLE_EQ(errors.sums().mpjpe_mm, 10);
  EXPECT_THAT(errors.sums().body_mm,
              ElementsAre(DoubleNear(10, 1e-12), DoubleNear(30, 1e-12)));
}

TEST(TrackingErrors, LocalErrorForgivesARootThatIsOff) {
  TrackingErrors errors(2, 30);

  errors.Add(Moved(0.3, 0.3), kReference);

  EXPECT_NEAR(errors.sums().mpjpe_mm, 0, 1e-12);
}

TEST(TrackingErrors, DifferencesStartWithTheSecondAndThirdFrame) {
  TrackingErrors errors(2, 30);

  // Errors of both bodies: 0, 1, 3, 6 mm. First differences 1, 2, 3; second
  // differences 1, 1.
  for (double mm : {0.0, 1.0, 3.0, 6.0}) {
    errors.Add(Moved(mm / 1000, mm / 1000), kReference);
  }

  EXPECT_EQ(errors.sums().velocity_frames, 3);
  EXPECT_EQ(errors.sums().acceleration_frames, 2);
  EXPECT_NEAR(errors.sums().velocity, 6, 1e-9);
  EXPECT_NEAR(errors.sums().acceleration, 2, 1e-9);
}

TEST(TrackingErrors, HaveNoChangeOverACut) {
  TrackingErrors errors(2, 30);

  for (double mm : {0.0, 1.0, 3.0}) {
    errors.Add(Moved(mm / 1000, mm / 1000), kReference);
  }
  errors.Restart();
  for (double mm : {100.0, 102.0, 105.0}) {
    errors.Add(Moved(mm / 1000, mm / 1000), kReference);
  }

  EXPECT_EQ(errors.sums().frames, 6);
  EXPECT_EQ(errors.sums().velocity_frames, 4);
  EXPECT_EQ(errors.sums().acceleration_frames, 2);
  EXPECT_NEAR(errors.sums().velocity, 8, 1e-9);
  EXPECT_NEAR(errors.sums().acceleration, 2, 1e-9);
}

TEST(TrackingErrors, CountVelocityPerThirtiethOfASecondAtAnyRate) {
  // The same motion, error 0.03 t + 0.6 t^2 m, sampled at 30 and at 60 Hz.
  for (double rate : {30.0, 60.0}) {
    TrackingErrors errors(2, rate);
    const int frames = static_cast<int>(rate);
    for (int i = 0; i <= frames; ++i) {
      const double t = i / rate;
      const double error = 0.03 * t + 0.6 * t * t;
      errors.Add(Moved(error, error), kReference);
    }
    const TrackingErrorSums& sums = errors.sums();
    // Mean velocity (0.03 + 0.6) m/s = 630 mm/s = 21 mm per 1/30 s;
    // acceleration 1.2 m/s^2 = 1200 / 900 mm per (1/30 s)^2.
    EXPECT_NEAR(sums.velocity / sums.velocity_frames, 21, 1e-9) << rate;
    EXPECT_NEAR(sums.acceleration / sums.acceleration_frames, 4.0 / 3, 1e-9)
        << rate;
  }
}

TEST(TrackingErrors, MeasureTheErrorNotTheMotion) {
  TrackingErrors errors(2, 30);

  for (double x : {0.0, 0.5, 0.1}) errors.Add(Moved(x, x), Moved(x, x));

  EXPECT_EQ(errors.sums().velocity, 0);
  EXPECT_EQ(errors.sums().acceleration, 0);
}

}  // namespace
}  // namespace sinew::metrics
