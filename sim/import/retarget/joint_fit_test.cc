#include "sim/import/retarget/joint_fit.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include "sim/import/retarget/hinge_chain.h"
#include "sim/motion/rotation.h"

namespace sinew::import {
namespace {

using Eigen::Quaterniond;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// Hinges along `axes`, all with the range [-limit, limit].
HingeChain Chain(const std::vector<Vector3d>& axes, double limit = kInfinity) {
  HingeChain chain;
  for (const Vector3d& axis : axes) {
    chain.joints.push_back(static_cast<int>(chain.joints.size()));
    chain.axes.push_back(axis.normalized());
    chain.lower.push_back(-limit);
    chain.upper.push_back(limit);
  }
  return chain;
}

const std::vector<Vector3d> kEuler = {{0, 1, 0}, {1, 0, 0}, {0, 0, 1}};
const std::vector<Vector3d> kTilted = {
    {0.3, 1, 0.2}, {1, -0.2, 0}, {0.1, 0, 1}};

// Largest angle between the targets and what the angles make.
double Worst(const HingeChain& chain, const std::vector<Quaterniond>& targets,
             const std::vector<VectorXd>& angles) {
  double worst = 0;
  for (size_t t = 0; t < targets.size(); ++t) {
    worst = std::max(
        worst, motion::AngleBetween(targets[t], chain.Rotation(angles[t])));
  }
  return worst;
}

double LargestStep(const std::vector<VectorXd>& angles) {
  double largest = 0;
  for (size_t t = 1; t < angles.size(); ++t) {
    largest =
        std::max(largest, (angles[t] - angles[t - 1]).cwiseAbs().maxCoeff());
  }
  return largest;
}

TEST(HingeChain, SolvesThreeHingesExactlyInTwoWays) {
  for (const auto& axes : {kEuler, kTilted}) {
    HingeChain chain = Chain(axes);
    chain.rest = motion::Exp({0.1, -0.3, 0.2});
    const Quaterniond target = chain.Rotation(Eigen::Vector3d(0.7, -0.4, 1.1));
    const auto solutions = chain.Solve(target);
    ASSERT_EQ(solutions.size(), 2u);
    for (const VectorXd& angles : solutions) {
      EXPECT_NEAR(motion::AngleBetween(chain.Rotation(angles), target), 0,
                  1e-9);
    }
    EXPECT_GT((solutions[0] - solutions[1]).norm(), 0.1);
  }
}

TEST(HingeChain, JacobianIsTheDerivativeOfTheRotation) {
  const HingeChain chain = Chain(kTilted);
  const VectorXd angles = Eigen::Vector3d(0.3, 0.9, -0.5);
  const Eigen::Matrix3Xd jacobian = chain.Jacobian(angles);
  for (int i = 0; i < 3; ++i) {
    VectorXd more = angles, less = angles;
    more[i] += 1e-6;
    less[i] -= 1e-6;
    const Vector3d slope =
        motion::Log(chain.Rotation(more) * chain.Rotation(less).conjugate()) /
        2e-6;
    EXPECT_NEAR((jacobian.col(i) - slope).norm(), 0, 1e-7);
  }
}

TEST(FitJoints, FollowsAReachableMotionExactlyAndContinuously) {
  const HingeChain chain = Chain(kTilted, 2.5);
  std::vector<Quaterniond> targets;
  for (int t = 0; t < 60; ++t) {
    const double s = 2 * std::numbers::pi * t / 60;
    targets.push_back(
        motion::Exp({std::sin(s), 0.8 * std::cos(s), 0.5 * std::sin(2 * s)}));
    if (t % 2 == 1) targets.back().coeffs() *= -1;
  }
  const auto angles = FitJoints(chain, targets, /*loops=*/true);
  EXPECT_LT(Worst(chain, targets, angles), 0.01);
  EXPECT_LT(LargestStep(angles), 0.5);
  EXPECT_LT((angles.front() - angles.back()).cwiseAbs().maxCoeff(), 0.5);
}

TEST(FitJoints, StaysContinuousThroughTheSingularDirection) {
  // Second angle through 90 degrees: first and third axis align there.
  const HingeChain chain = Chain(kEuler);
  std::vector<Quaterniond> targets;
  for (int t = 0; t <= 40; ++t) {
    targets.push_back(motion::Exp({0, 0, 0.1}) *
                      motion::Exp({3.0 * t / 40, 0, 0}) *
                      motion::Exp({0, 0.02, 0}));
  }
  const auto angles = FitJoints(chain, targets, /*loops=*/false);
  EXPECT_LT(Worst(chain, targets, angles), 0.15);
  // A branch change would turn two hinges by pi from one frame to the next.
  EXPECT_LT(LargestStep(angles), 0.8);
}

TEST(FitJoints, HoldsTheLimitsAndComesAsNearAsTheyAllow) {
  const HingeChain chain = Chain({{0, 1, 0}}, 1.0);
  std::vector<Quaterniond> targets;
  for (int t = 0; t <= 30; ++t) {
    targets.push_back(motion::Exp({0, 1.4 * t / 30, 0}));
  }
  int cut = 0;
  const auto angles = FitJoints(chain, targets, /*loops=*/false, &cut);
  for (const VectorXd& frame : angles) EXPECT_LE(frame[0], 1.0);
  EXPECT_NEAR(angles.back()[0], 1.0, 1e-6);
  EXPECT_NEAR(Worst(chain, targets, angles), 0.4, 0.01);
  // The targets of frames 22 to 30 are beyond the limit.
  EXPECT_EQ(cut, 9);
}

TEST(FitJoints, TakesTheSolutionWithinTheLimits) {
  HingeChain chain = Chain(kEuler, 1.4);
  std::vector<Quaterniond> targets;
  for (int t = 0; t < 20; ++t) {
    targets.push_back(chain.Rotation(
        Eigen::Vector3d(1.2 - 0.02 * t, 0.5 + 0.01 * t, -1.1 + 0.03 * t)));
  }
  int cut = 0;
  const auto angles = FitJoints(chain, targets, /*loops=*/false, &cut);
  EXPECT_EQ(cut, 0);
  EXPECT_LT(Worst(chain, targets, angles), 0.01);
  EXPECT_NEAR(angles[10][0], 1.0, 0.02);
}

}  // namespace
}  // namespace sinew::import
