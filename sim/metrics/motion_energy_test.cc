#include "sim/metrics/motion_energy.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace sinew::metrics {
namespace {

constexpr double kRate = 10;

TEST(MotionEnergy, IsZeroForABodyThatRests) {
  MotionEnergyMeter meter(kRate);

  for (int i = 0; i < 3; ++i) {
    meter.Add(std::vector<Eigen::Vector3d>{{1, 2, 3}}, {0.0, 0.0});
  }

  EXPECT_EQ(meter.figures().root_speed_m_per_s(), 0);
  EXPECT_EQ(meter.figures().joint_speed_rad_per_s(), 0);
  EXPECT_EQ(meter.figures().acceleration_m_per_s2(), 0);
}

TEST(MotionEnergy, MeasuresSpeedOverTheFloorAndAcceleration) {
  MotionEnergyMeter meter(kRate);

  // Root at 0, 1, 3 m: speeds 10 and 20 m/s, second difference 1 m, which at
  // 10 Hz is 100 m/s^2; the other body rises steadily. Mean over bodies 50.
  const double x[] = {0, 1, 3};
  for (int i = 0; i < 3; ++i) {
    meter.Add(std::vector<Eigen::Vector3d>{{x[i], 0, 0}, {0, 0, 1.0 * i}},
              {3.0, -4.0});
  }

  EXPECT_DOUBLE_EQ(meter.figures().root_speed_m_per_s(), 15);
  EXPECT_DOUBLE_EQ(meter.figures().acceleration_m_per_s2(), 50);
  // Root of the mean of 9 and 16.
  EXPECT_DOUBLE_EQ(meter.figures().joint_speed_rad_per_s(), std::sqrt(12.5));
}

TEST(MotionEnergy, AddsUpOverMotions) {
  MotionEnergy all = {.frames = 1,
                      .differences = 1,
                      .second_differences = 2,
                      .root_speed = 1,
                      .joint_speed_square = 16,
                      .acceleration = 4};

  all.Add({.frames = 3,
           .differences = 3,
           .second_differences = 6,
           .root_speed = 7,
           .joint_speed_square = 20,
           .acceleration = 12});

  EXPECT_EQ(all.frames, 4);
  EXPECT_DOUBLE_EQ(all.root_speed_m_per_s(), 2);
  EXPECT_DOUBLE_EQ(all.joint_speed_rad_per_s(), 3);  // sqrt(36 / 4)
  EXPECT_DOUBLE_EQ(all.acceleration_m_per_s2(), 2);  // 16 / 8
}

}  // namespace
}  // namespace sinew::metrics
