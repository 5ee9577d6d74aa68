#ifndef SINEW_SIM_IMPORT_RETARGET_PUSH_FIT_H_
#define SINEW_SIM_IMPORT_RETARGET_PUSH_FIT_H_

#include <Eigen/Dense>
#include <vector>

namespace sinew::import {

// What pushes one body: unit pushes as wrenches, and what a wrench on the body
// does to the target.
struct PushGroup {
  Eigen::Matrix<double, Eigen::Dynamic, 6> map;       // [rows, 6]
  Eigen::Matrix<double, 6, Eigen::Dynamic> wrenches;  // [6, pushes]
};

// Solution x of: minimise |b - A x|^2 + cost^2 |x|^2 over x >= 0, where the
// columns of A are those of map * wrenches of all groups.
//
// By its dual. Optimal are exactly x = max(0, A' r) / cost^2 with r = b - A x,
// so r minimises the convex
//   f(r) = |r|^2 / 2 + |max(0, A' r)|^2 / 2 cost^2 - b' r,
// piecewise quadratic and of few unknowns however many columns A has: Newton's
// method with step halving ends after a few pieces, after one or two from a
// good guess.
//
// Thread-safety: one thread. Ownership: borrows the groups and the target.
// Blocking: never. Errors: none; after kSteps it stops where it is.
class PushFit {
 public:
  PushFit(const std::vector<PushGroup>& groups, const Eigen::VectorXd& target,
          double cost);

  // From a guess of r.
  void Solve(const Eigen::VectorXd& guess);

  // x of one group, [pushes].
  Eigen::VectorXd Pushes(int group) const;
  // r, [rows].
  const Eigen::VectorXd& remainder() const { return r_; }
  // Its lower half is the Cholesky factor L: r changes with b by (L L')^-1.
  const Eigen::MatrixXd& factor() const { return factor_; }

 private:
  static constexpr int kSteps = 50;

  // All there is to know at r.
  struct Place {
    std::vector<Eigen::VectorXd> along;  // [groups] max(0, A' r)
    double value = 0;
  };
  void Visit(const Eigen::VectorXd& r, Place* place) const;
  Eigen::VectorXd Gradient(const Place& place) const;
  void Factorise(const Place& place);

  const std::vector<PushGroup>& groups_;
  const Eigen::VectorXd& target_;
  const double scale_;
  Eigen::VectorXd r_;
  Place here_;
  Eigen::MatrixXd factor_;
};

}  // namespace sinew::import

#endif  // SINEW_SIM_IMPORT_RETARGET_PUSH_FIT_H_
