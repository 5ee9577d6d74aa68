#include "sim/import/retarget/normal_equations.h"

#include <algorithm>

#include "common/check.h"

namespace sinew::import {
namespace {

using Eigen::Lower;
using Eigen::MatrixXd;
using Eigen::Upper;
using Eigen::VectorXd;

constexpr int kBand = 2;  // residuals reach this many frames far

}  // namespace

NormalEquations::NormalEquations(int frames, int coordinates, bool ring)
    : frames_(frames),
      coordinates_(coordinates),
      border_(ring ? frames - kBand : frames),
      panels_(frames),
      gradient_(VectorXd::Zero(frames * coordinates)) {
  SINEW_CHECK(!ring || frames > kBand) << frames << " frames";
  for (int t = 0; t < frames; ++t) {
    panels_[t].setZero((1 + Followers(t)) * coordinates, coordinates);
  }
  factor_ = panels_;
}

void NormalEquations::Clear() {
  for (MatrixXd& panel : panels_) panel.setZero();
  gradient_.setZero();
}

int NormalEquations::Followers(int frame) const {
  if (frame >= border_) return frames_ - 1 - frame;
  return std::min(kBand, border_ - 1 - frame) + frames_ - border_;
}

int NormalEquations::Follower(int frame, int index) const {
  const int in_band = std::max(0, std::min(kBand, border_ - 1 - frame));
  if (frame >= border_ || index < in_band) return frame + 1 + index;
  return border_ + index - in_band;
}

int NormalEquations::Offset(int row, int column) const {
  if (row < border_ || column >= border_) return (row - column) * coordinates_;
  const int in_band = std::min(kBand, border_ - 1 - column);
  return (1 + in_band + row - border_) * coordinates_;
}

Eigen::Block<MatrixXd> NormalEquations::Block(int row, int column) {
  SINEW_DCHECK(row >= column) << row << " before " << column;
  return panels_[column].block(Offset(row, column), 0, coordinates_,
                               coordinates_);
}

Eigen::VectorBlock<VectorXd> NormalEquations::Gradient(int frame) {
  return gradient_.segment(frame * coordinates_, coordinates_);
}

void NormalEquations::Add(absl::Span<const FrameBlock> blocks,
                          const Eigen::Ref<const VectorXd>& residual) {
  for (const FrameBlock& a : blocks) {
    Gradient(a.frame).noalias() += a.jacobian.transpose() * residual;
    for (const FrameBlock& b : blocks) {
      if (b.frame > a.frame) continue;
      if (b.frame == a.frame) {
        Block(a.frame, a.frame)
            .selfadjointView<Lower>()
            .rankUpdate(a.jacobian.transpose());
      } else {
        Block(a.frame, b.frame).noalias() +=
            a.jacobian.transpose() * b.jacobian;
      }
    }
  }
}

// Cholesky, panel by panel: a finished one is taken off those that it touches.
bool NormalEquations::Eliminate(int t) {
  const int c = coordinates_;
  MatrixXd& panel = factor_[t];
  Eigen::Ref<MatrixXd> diagonal = panel.topRows(c);
  const Eigen::LLT<Eigen::Ref<MatrixXd>> in_place(diagonal);
  if (in_place.info() != Eigen::Success) return false;
  const int followers = Followers(t);
  auto below = panel.bottomRows(followers * c);
  diagonal.transpose().triangularView<Upper>().solveInPlace<Eigen::OnTheRight>(
      below);
  for (int k = 0; k < followers; ++k) {
    const int column = Follower(t, k);
    const auto right = below.middleRows(k * c, c);
    // Rows that lie side by side in both panels go together.
    for (int i = k; i < followers;) {
      const int first = Offset(Follower(t, i), column);
      int end = i + 1;
      while (end < followers &&
             Offset(Follower(t, end), column) == first + (end - i) * c) {
        ++end;
      }
      factor_[column].middleRows(first, (end - i) * c).noalias() -=
          below.middleRows(i * c, (end - i) * c) * right.transpose();
      i = end;
    }
  }
  return true;
}

std::vector<VectorXd> NormalEquations::Solve(double damping) {
  const int c = coordinates_;
  for (int t = 0; t < frames_; ++t) {
    factor_[t] = panels_[t];
    auto diagonal = factor_[t].topRows(c).diagonal();
    diagonal.array() += damping * (1 + diagonal.array());
  }
  std::vector<VectorXd> steps(frames_);
  for (int t = 0; t < frames_; ++t) steps[t] = -Gradient(t);
  for (int t = 0; t < frames_; ++t) {
    if (!Eliminate(t)) return {};
    factor_[t].topRows(c).triangularView<Lower>().solveInPlace(steps[t]);
    for (int k = 0; k < Followers(t); ++k) {
      steps[Follower(t, k)].noalias() -=
          factor_[t].middleRows((k + 1) * c, c) * steps[t];
    }
  }
  for (int t = frames_ - 1; t >= 0; --t) {
    for (int k = 0; k < Followers(t); ++k) {
      steps[t].noalias() -= factor_[t].middleRows((k + 1) * c, c).transpose() *
                            steps[Follower(t, k)];
    }
    factor_[t].topRows(c).transpose().triangularView<Upper>().solveInPlace(
        steps[t]);
  }
  return steps;
}

}  // namespace sinew::import
