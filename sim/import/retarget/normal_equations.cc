#include "sim/import/retarget/normal_equations.h"

#include <Eigen/SparseCholesky>

namespace sinew::import {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

}  // namespace

NormalEquations::NormalEquations(int frames, int coordinates)
    : frames_(frames),
      coordinates_(coordinates),
      gradient_(VectorXd::Zero(frames * coordinates)) {
  for (int t = 0; t < frames; ++t) Block(t, t);
}

MatrixXd& NormalEquations::Block(int row, int column) {
  MatrixXd& block = blocks_[{row, column}];
  if (block.size() == 0) block.setZero(coordinates_, coordinates_);
  return block;
}

void NormalEquations::Add(absl::Span<const FrameBlock> blocks,
                          const VectorXd& residual) {
  Add(blocks, residual,
      MatrixXd::Identity(residual.size(), residual.size()));
}

void NormalEquations::Add(absl::Span<const FrameBlock> blocks,
                          const VectorXd& residual, const MatrixXd& metric) {
  for (const FrameBlock& a : blocks) {
    gradient_.segment(a.frame * coordinates_, coordinates_) +=
        a.jacobian.transpose() * residual;
    const MatrixXd weighted = a.jacobian.transpose() * metric;
    for (const FrameBlock& b : blocks) {
      if (b.frame > a.frame) continue;
      Block(a.frame, b.frame) += weighted * b.jacobian;
    }
  }
}

void NormalEquations::AddScalar(int frame, int coordinate, double weight,
                                double offset) {
  const double square = weight * weight;
  Block(frame, frame)(coordinate, coordinate) += square;
  gradient_[frame * coordinates_ + coordinate] += square * offset;
}

std::vector<VectorXd> NormalEquations::Solve(double damping) const {
  const int size = frames_ * coordinates_;
  std::vector<Eigen::Triplet<double>> entries;
  for (const auto& [place, block] : blocks_) {
    const bool diagonal = place.first == place.second;
    for (int i = 0; i < coordinates_; ++i) {
      for (int j = 0; j < (diagonal ? i + 1 : coordinates_); ++j) {
        double value = block(i, j);
        if (diagonal && i == j) value += damping * (1 + value);
        entries.emplace_back(place.first * coordinates_ + i,
                             place.second * coordinates_ + j, value);
      }
    }
  }
  Eigen::SparseMatrix<double> matrix(size, size);
  matrix.setFromTriplets(entries.begin(), entries.end());
  const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>, Eigen::Lower>
      solver(matrix);
  if (solver.info() != Eigen::Success) return {};
  const VectorXd solution = solver.solve(-gradient_);
  std::vector<VectorXd> steps;
  for (int t = 0; t < frames_; ++t) {
    steps.push_back(solution.segment(t * coordinates_, coordinates_));
  }
  return steps;
}

}  // namespace sinew::import
