#include "sim/motion/resample.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "sim/motion/rotation.h"

namespace sinew::motion {
namespace {

using Eigen::Quaterniond;
using Eigen::Vector3d;

// Uneven keys.
const std::vector<double> kTimes = {0, 0.1, 0.35, 0.5, 0.9};

std::vector<double> Fine() {
  std::vector<double> times;
  for (int i = 0; i <= 900; ++i) times.push_back(i * 1e-3);
  return times;
}

TEST(Resample, PassesThroughEveryKey) {
  std::vector<Vector3d> vectors;
  std::vector<Quaterniond> rotations;
  for (const double t : kTimes) {
    vectors.emplace_back(std::sin(7 * t), t, -t * t);
    rotations.push_back(Exp({std::sin(9 * t), 2 * t, std::cos(5 * t)}));
  }
  const auto same_vectors = ResampleVectors(kTimes, vectors, kTimes);
  const auto same_rotations = ResampleRotations(kTimes, rotations, kTimes);
  for (size_t i = 0; i < kTimes.size(); ++i) {
    EXPECT_NEAR((same_vectors[i] - vectors[i]).norm(), 0, 1e-12);
    EXPECT_NEAR(AngleBetween(same_rotations[i], rotations[i]), 0, 1e-9);
  }
}

TEST(Resample, IsStraightForVectorsAndSlerpForRotationsAtConstantVelocity) {
  const Vector3d velocity(1, -2, 0.5);
  const Vector3d rate(-0.3, 2, 1);
  std::vector<Vector3d> vectors;
  std::vector<Quaterniond> rotations;
  for (const double t : kTimes) {
    vectors.push_back(t * velocity);
    rotations.push_back(Exp(t * rate));
  }
  const std::vector<double> fine = Fine();
  const auto points = ResampleVectors(kTimes, vectors, fine);
  const auto turns = ResampleRotations(kTimes, rotations, fine);
  for (size_t i = 0; i < fine.size(); ++i) {
    EXPECT_NEAR((points[i] - fine[i] * velocity).norm(), 0, 1e-12);
    EXPECT_NEAR(AngleBetween(turns[i], Exp(fine[i] * rate)), 0, 1e-9);
  }
}

TEST(Resample, HasAContinuousVelocityAcrossKeys) {
  std::vector<Quaterniond> rotations;
  for (const double t : kTimes) {
    rotations.push_back(Exp({std::sin(9 * t), 2 * t, std::cos(5 * t)}));
  }
  const std::vector<double> fine = Fine();
  const auto turns = ResampleRotations(kTimes, rotations, fine);
  Vector3d last = Log(turns[0].conjugate() * turns[1]) / 1e-3;
  for (size_t i = 1; i + 1 < turns.size(); ++i) {
    const Vector3d rate = Log(turns[i].conjugate() * turns[i + 1]) / 1e-3;
    // The largest change of rate within a millisecond is about 0.2 rad/s; a
    // kink of plain slerp would be several.
    EXPECT_LT((rate - last).norm(), 0.5) << "at " << fine[i];
    last = rate;
  }
}

TEST(Resample, GivesQuaternionsOfContinuousSign) {
  std::vector<Quaterniond> rotations;
  for (size_t i = 0; i < kTimes.size(); ++i) {
    rotations.push_back(Exp({0, 0, 2.5 * kTimes[i]}));
    if (i % 2 == 1) rotations.back().coeffs() *= -1;
  }
  const auto turns = ResampleRotations(kTimes, rotations, Fine());
  for (size_t i = 1; i < turns.size(); ++i) {
    EXPECT_GT(turns[i].dot(turns[i - 1]), 0.9);
  }
}

TEST(SampleTimes, SpreadsSamplesOverTheClipAndLeavesALoopsEndOut) {
  const auto once = SampleTimes(1.02, 30, /*loops=*/false);
  ASSERT_EQ(once.size(), 32u);
  EXPECT_DOUBLE_EQ(once.back(), 1.02);
  const auto loop = SampleTimes(1.02, 30, /*loops=*/true);
  ASSERT_EQ(loop.size(), 31u);
  EXPECT_DOUBLE_EQ(loop.back(), 1.02 * 30 / 31);
  EXPECT_EQ(SampleTimes(1e-3, 30, /*loops=*/false).size(), 2u);
}

}  // namespace
}  // namespace sinew::motion
