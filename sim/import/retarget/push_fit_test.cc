#include "sim/import/retarget/push_fit.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace sinew::import {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr int kRows = 14;
constexpr int kPushes = 12;
constexpr double kCost = 0.05;

// A number between -1 and 1 that depends on all arguments.
double Made(int a, int b) { return std::sin(1.3 * a + 2.7 * b + 0.4 * a * b); }

std::vector<PushGroup> MakeGroups() {
  std::vector<PushGroup> groups(2);
  for (int g = 0; g < 2; ++g) {
    groups[g].map = MatrixXd::NullaryExpr(
        kRows, 6, [g](Eigen::Index row, Eigen::Index column) {
          return Made(static_cast<int>(row) + 20 * g, static_cast<int>(column));
        });
    groups[g].wrenches = MatrixXd::NullaryExpr(
        6, kPushes, [g](Eigen::Index row, Eigen::Index column) {
          return Made(static_cast<int>(column) + 30 * g,
                      static_cast<int>(row) + 7);
        });
  }
  return groups;
}

VectorXd MakeTarget() {
  VectorXd target(kRows);
  for (int i = 0; i < kRows; ++i) target[i] = Made(i, 40);
  return target;
}

// b - A x, the second way.
VectorXd Remainder(const std::vector<PushGroup>& groups, const PushFit& fit,
                   const VectorXd& target) {
  return target - groups[0].map * (groups[0].wrenches * fit.Pushes(0)) -
         groups[1].map * (groups[1].wrenches * fit.Pushes(1));
}

TEST(PushFit, MeetsTheConditionsOfTheMinimum) {
  const auto groups = MakeGroups();
  const VectorXd target = MakeTarget();
  PushFit fit(groups, target, kCost);

  fit.Solve(target);

  EXPECT_NEAR((fit.remainder() - Remainder(groups, fit, target)).norm(), 0,
              1e-9);
  int pushing = 0;
  for (int g = 0; g < 2; ++g) {
    const VectorXd pushes = fit.Pushes(g);
    // Half the derivative of the cost by x.
    const VectorXd slope =
        kCost * kCost * pushes -
        groups[g].wrenches.transpose() *
            (groups[g].map.transpose() * Remainder(groups, fit, target));
    for (int i = 0; i < kPushes; ++i) {
      EXPECT_GE(pushes[i], 0);
      if (pushes[i] > 0) EXPECT_NEAR(slope[i], 0, 1e-9);
      if (pushes[i] == 0) EXPECT_GE(slope[i], -1e-9);
      pushing += pushes[i] > 0 ? 1 : 0;
    }
  }
  EXPECT_GT(pushing, 3);
  EXPECT_LT(pushing, 2 * kPushes - 3);
}

TEST(PushFit, EndsAtTheSameFromAnyGuess) {
  const auto groups = MakeGroups();
  const VectorXd target = MakeTarget();
  PushFit plain(groups, target, kCost);
  plain.Solve(target);
  for (const double size : {0.0, 1.0, -100.0}) {
    PushFit fit(groups, target, kCost);
    fit.Solve(VectorXd::Constant(kRows, size));
    EXPECT_NEAR((fit.remainder() - plain.remainder()).norm(), 0, 1e-9);
    EXPECT_NEAR((fit.Pushes(0) - plain.Pushes(0)).norm(), 0, 1e-7);
  }
}

TEST(PushFit, FactorTellsHowTheRemainderFollowsTheTarget) {
  const auto groups = MakeGroups();
  const VectorXd target = MakeTarget();
  PushFit fit(groups, target, kCost);
  fit.Solve(target);
  const MatrixXd lower = fit.factor().triangularView<Eigen::Lower>();
  const MatrixXd follows = (lower * lower.transpose()).inverse();
  constexpr double kStep = 1e-6;
  for (int i = 0; i < kRows; ++i) {
    VectorXd other = target;
    other[i] += kStep;
    PushFit moved(groups, other, kCost);
    moved.Solve(other);
    const VectorXd slope = (moved.remainder() - fit.remainder()) / kStep;
    EXPECT_NEAR((slope - follows.col(i)).norm(), 0, 1e-4) << "row " << i;
  }
}

}  // namespace
}  // namespace sinew::import
