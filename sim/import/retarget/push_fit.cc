#include "sim/import/retarget/push_fit.h"

#include <utility>

#include "sim/import/retarget/spatial.h"

namespace sinew::import {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

// Gradients smaller than this, relative to the target, are rounding.
constexpr double kRounding = 1e-11;
constexpr double kShortestStep = 1e-6;

bool SamePieces(const std::vector<VectorXd>& a,
                const std::vector<VectorXd>& b) {
  for (size_t g = 0; g < a.size(); ++g) {
    if (((a[g].array() > 0) != (b[g].array() > 0)).any()) return false;
  }
  return true;
}

}  // namespace

PushFit::PushFit(const std::vector<PushGroup>& groups, const VectorXd& target,
                 double cost)
    : groups_(groups), target_(target), scale_(1 / (cost * cost)) {
  here_.along.resize(groups.size());
}

void PushFit::Solve(const VectorXd& guess) {
  r_ = guess;
  Visit(r_, &here_);
  Factorise(here_);
  Place next = here_;
  for (int i = 0; i < kSteps; ++i) {
    const VectorXd gradient = Gradient(here_);
    if (gradient.norm() <= kRounding * (1 + target_.norm())) return;
    VectorXd step = -gradient;
    factor_.triangularView<Eigen::Lower>().solveInPlace(step);
    factor_.transpose().triangularView<Eigen::Upper>().solveInPlace(step);
    const double slope = gradient.dot(step);
    double length = 1;
    for (Visit(r_ + step, &next);
         next.value > here_.value + 1e-4 * length * slope &&
         length > kShortestStep;) {
      length /= 2;
      Visit(r_ + length * step, &next);
    }
    r_ += length * step;
    const bool same = SamePieces(here_.along, next.along);
    std::swap(here_, next);
    // A whole step within one piece ends at the minimum.
    if (same && length == 1) return;
    if (!same) Factorise(here_);
  }
}

VectorXd PushFit::Pushes(int group) const {
  return scale_ * here_.along[group];
}

void PushFit::Visit(const VectorXd& r, Place* place) const {
  double squares = 0;
  for (size_t g = 0; g < groups_.size(); ++g) {
    const Vector6 seen = groups_[g].map.transpose() * r;
    place->along[g].noalias() = groups_[g].wrenches.transpose() * seen;
    place->along[g] = place->along[g].cwiseMax(0.0);
    squares += place->along[g].squaredNorm();
  }
  place->value = r.squaredNorm() / 2 - target_.dot(r) + scale_ / 2 * squares;
}

// At the place of r_.
VectorXd PushFit::Gradient(const Place& place) const {
  VectorXd gradient = r_ - target_;
  for (size_t g = 0; g < groups_.size(); ++g) {
    const Vector6 wrench = scale_ * (groups_[g].wrenches * place.along[g]);
    gradient.noalias() += groups_[g].map * wrench;
  }
  return gradient;
}

void PushFit::Factorise(const Place& place) {
  const auto n = target_.size();
  factor_ = MatrixXd::Identity(n, n);
  for (size_t g = 0; g < groups_.size(); ++g) {
    const PushGroup& group = groups_[g];
    Matrix6 sum = Matrix6::Zero();
    bool pushes = false;
    for (int i = 0; i < place.along[g].size(); ++i) {
      if (place.along[g][i] <= 0) continue;
      const Vector6 wrench = group.wrenches.col(i);
      sum.noalias() += scale_ * wrench * wrench.transpose();
      pushes = true;
    }
    if (!pushes) continue;
    const Eigen::Matrix<double, Eigen::Dynamic, 6> weighted = group.map * sum;
    factor_.noalias() += weighted * group.map.transpose();
  }
  Eigen::LLT<Eigen::Ref<MatrixXd>> in_place(factor_);
}

}  // namespace sinew::import
