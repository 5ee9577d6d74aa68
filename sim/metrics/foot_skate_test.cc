#include "sim/metrics/foot_skate.h"

#include <gtest/gtest.h>

#include <vector>

namespace sinew::metrics {
namespace {

constexpr double kRate = 30;

// One foot with heel and toe, each at x and height.
std::vector<Eigen::Vector3d> Foot(double heel_x, double heel_z, double toe_x,
                                  double toe_z) {
  return {{heel_x, 0, heel_z}, {toe_x, 0, toe_z}};
}

TEST(FootSkate, IsTheSpeedOfAFootThatTouches) {
  FootSkateMeter meter({0, 0}, /*feet=*/1, kRate);

  // 1 cm per frame on the floor: 0.3 m/s.
  for (int i = 0; i < 4; ++i) {
    meter.Add(Foot(0.01 * i, 0.001, 0.2 + 0.01 * i, 0.002));
  }

  EXPECT_EQ(meter.figures().contacts, 3);
  EXPECT_NEAR(meter.figures().mean_m_per_s(), 0.3, 1e-12);
}

TEST(FootSkate, IgnoresAFootInTheAir) {
  FootSkateMeter meter({0, 0}, /*feet=*/1, kRate);

  meter.Add(Foot(0, 0.001, 0.2, 0.001));
  meter.Add(Foot(1, 0.1, 1.2, 0.1));  // lifted: touches before, not after
  meter.Add(Foot(2, 0.1, 2.2, 0.1));

  EXPECT_EQ(meter.figures().contacts, 0);
  EXPECT_EQ(meter.figures().mean_m_per_s(), 0);
}

TEST(FootSkate, AFootThatRollsOverItsToeStands) {
  FootSkateMeter meter({0, 0}, /*feet=*/1, kRate);

  meter.Add(Foot(0, 0.001, 0.2, 0));
  meter.Add(Foot(0.05, 0.06, 0.2, 0));  // the heel rises, the toe stays

  EXPECT_EQ(meter.figures().contacts, 1);
  EXPECT_EQ(meter.figures().mean_m_per_s(), 0);
}

TEST(FootSkate, CountsEachFootByItself) {
  FootSkateMeter meter({0, 1}, /*feet=*/2, kRate);

  // The first slides 2 cm, the second is in the air.
  meter.Add(std::vector<Eigen::Vector3d>{{0, 0, 0}, {0, 1, 0.3}});
  meter.Add(std::vector<Eigen::Vector3d>{{0, 0.02, 0}, {0, 2, 0.3}});

  EXPECT_EQ(meter.figures().contacts, 1);
  EXPECT_NEAR(meter.figures().mean_m_per_s(), 0.6, 1e-12);
}

TEST(FootSkate, AddsUpOverMotions) {
  FootSkate all = {.contacts = 1, .sum_m_per_s = 0.2};

  all.Add({.contacts = 3, .sum_m_per_s = 1.0});

  EXPECT_EQ(all.contacts, 4);
  EXPECT_DOUBLE_EQ(all.mean_m_per_s(), 0.3);
}

}  // namespace
}  // namespace sinew::metrics
