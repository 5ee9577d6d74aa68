#include "sim/import/retarget/normal_equations.h"

#include <gtest/gtest.h>

#include <cmath>
#include <tuple>
#include <vector>

namespace sinew::import {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr int kCoordinates = 4;
constexpr int kRows = 5;

// A number between -1 and 1 that depends on all arguments.
double Made(int a, int b, int c) {
  return std::sin(1.3 * a + 2.7 * b * b + 0.9 * c + 0.1 * a * c);
}

// Residuals over three frames in a row, as many as the clip has places for.
struct Problem {
  NormalEquations equations;
  MatrixXd jacobian;
  VectorXd residual;
};

Problem MakeProblem(int frames, bool ring) {
  const int count = ring ? frames : frames - 2;
  Problem problem{NormalEquations(frames, kCoordinates, ring),
                  MatrixXd::Zero(count * kRows, frames * kCoordinates),
                  VectorXd(count * kRows)};
  for (int i = 0; i < count; ++i) {
    VectorXd residual(kRows);
    MatrixXd parts[3];
    std::vector<FrameBlock> blocks;
    for (int row = 0; row < kRows; ++row) residual[row] = Made(i, row, 50);
    for (int k = 0; k < 3; ++k) {
      const int frame = (i + k) % frames;
      parts[k] = MatrixXd::NullaryExpr(
          kRows, kCoordinates, [&](Eigen::Index row, Eigen::Index column) {
            return Made(static_cast<int>(column) + 10 * i,
                        static_cast<int>(row), k) +
                   (k == 1 && row == column ? 2 : 0);
          });
      blocks.push_back({frame, parts[k]});
      problem.jacobian.block(i * kRows, frame * kCoordinates, kRows,
                             kCoordinates) = parts[k];
    }
    problem.equations.Add(blocks, residual);
    problem.residual.segment(i * kRows, kRows) = residual;
  }
  return problem;
}

VectorXd Flat(const std::vector<VectorXd>& steps) {
  VectorXd flat(static_cast<int>(steps.size()) * kCoordinates);
  for (size_t t = 0; t < steps.size(); ++t) {
    flat.segment(static_cast<int>(t) * kCoordinates, kCoordinates) = steps[t];
  }
  return flat;
}

class NormalEquationsTest
    : public ::testing::TestWithParam<std::tuple<int, bool>> {};

TEST_P(NormalEquationsTest, AgreeWithADenseSolution) {
  const auto [frames, ring] = GetParam();
  Problem problem = MakeProblem(frames, ring);
  constexpr double kDamping = 0.01;
  MatrixXd matrix = problem.jacobian.transpose() * problem.jacobian;
  matrix.diagonal().array() += kDamping * (1 + matrix.diagonal().array());
  const VectorXd gradient = problem.jacobian.transpose() * problem.residual;
  const VectorXd expected = -matrix.ldlt().solve(gradient);

  const auto found = problem.equations.Solve(kDamping);

  EXPECT_NEAR((problem.equations.gradient() - gradient).norm(), 0, 1e-9);
  ASSERT_EQ(found.size(), static_cast<size_t>(frames));
  EXPECT_NEAR((Flat(found) - expected).norm(), 0, 1e-8);
}

TEST_P(NormalEquationsTest, ForgetWhatIsCleared) {
  const auto [frames, ring] = GetParam();
  Problem problem = MakeProblem(frames, ring);
  problem.equations.Clear();
  EXPECT_EQ(problem.equations.gradient().norm(), 0);
  for (int t = 0; t < frames; ++t) {
    problem.equations.Block(t, t).diagonal().setConstant(2);
    problem.equations.Gradient(t).setConstant(t);
  }
  const auto found = problem.equations.Solve(0);
  ASSERT_EQ(found.size(), static_cast<size_t>(frames));
  for (int t = 0; t < frames; ++t) {
    EXPECT_NEAR((found[t].array() + t / 2.0).abs().maxCoeff(), 0, 1e-12);
  }
}

INSTANTIATE_TEST_SUITE_P(LinesAndRings, NormalEquationsTest,
                         ::testing::Combine(::testing::Values(3, 4, 5, 6, 12),
                                            ::testing::Bool()));

TEST(NormalEquations, ReportAMatrixThatIsNotPositiveDefinite) {
  NormalEquations equations(4, kCoordinates, /*ring=*/false);
  EXPECT_TRUE(equations.Solve(0).empty());
}

}  // namespace
}  // namespace sinew::import
