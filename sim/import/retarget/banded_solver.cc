#include "sim/import/retarget/banded_solver.h"

#include <algorithm>
#include <cmath>

namespace sinew::import {

using Eigen::MatrixXd;
using Eigen::VectorXd;

BandedSolver::BandedSolver(int frames, int size) : blocks_(frames) {
  for (auto& row : blocks_) {
    for (MatrixXd& block : row) block.setZero(size, size);
  }
}

bool BandedSolver::Solve(std::vector<VectorXd>* x) {
  const int frames = static_cast<int>(blocks_.size());
  // Block Cholesky, row by row: L(t, s) for s = t - 2, t - 1, t.
  for (int t = 0; t < frames; ++t) {
    auto& row = blocks_[t];
    for (int back = std::min(kBand, t); back > 0; --back) {
      const int s = t - back;
      for (int further = back + 1; further <= std::min(kBand, t); ++further) {
        row[back].noalias() -=
            row[further] * blocks_[s][further - back].transpose();
      }
      blocks_[s][0]
          .triangularView<Eigen::Lower>()
          .transpose()
          .solveInPlace<Eigen::OnTheRight>(row[back]);
    }
    for (int back = 1; back <= std::min(kBand, t); ++back) {
      row[0].selfadjointView<Eigen::Lower>().rankUpdate(row[back], -1.0);
    }
    Eigen::LLT<Eigen::Ref<MatrixXd>> factor(row[0]);
    if (factor.info() != Eigen::Success) return false;
  }
  for (int t = 0; t < frames; ++t) {
    VectorXd& value = (*x)[t];
    for (int back = 1; back <= std::min(kBand, t); ++back) {
      value.noalias() -= blocks_[t][back] * (*x)[t - back];
    }
    blocks_[t][0].triangularView<Eigen::Lower>().solveInPlace(value);
    if (!value.allFinite()) return false;
  }
  for (int t = frames - 1; t >= 0; --t) {
    VectorXd& value = (*x)[t];
    for (int ahead = 1; ahead <= kBand && t + ahead < frames; ++ahead) {
      value.noalias() -=
          blocks_[t + ahead][ahead].transpose() * (*x)[t + ahead];
    }
    blocks_[t][0].triangularView<Eigen::Lower>().transpose().solveInPlace(
        value);
  }
  return true;
}

}  // namespace sinew::import
