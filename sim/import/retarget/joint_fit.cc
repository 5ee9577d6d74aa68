#include "sim/import/retarget/joint_fit.h"

#include <Eigen/SparseCholesky>
#include <algorithm>
#include <cmath>
#include <limits>

#include "common/check.h"
#include "sim/motion/rotation.h"

namespace sinew::import {
namespace {

using Eigen::MatrixXd;
using Eigen::Quaterniond;
using Eigen::VectorXd;
using Series = std::vector<VectorXd>;

// Weights of the fit; a radian of rotation error costs 1. Per radian beyond a
// limit:
constexpr double kLimit = 3;
// Per radian of change between frames, and of change of that change.
constexpr double kVelocity = 0.01;
constexpr double kAcceleration = 0.03;
// Gauss-Newton steps at most.
constexpr int kSteps = 30;
// An angle beyond a limit by more than this counts as cut, rad.
constexpr double kCutTolerance = 0.0175;

// How far `angle` lies outside [lower, upper], with sign.
double Excess(double angle, double lower, double upper) {
  if (angle > upper) return angle - upper;
  if (angle < lower) return angle - lower;
  return 0;
}

double LimitCost(const HingeChain& chain, const VectorXd& angles) {
  double cost = 0;
  for (int i = 0; i < chain.size(); ++i) {
    const double excess = Excess(angles[i], chain.lower[i], chain.upper[i]);
    cost += excess * excess;
  }
  return cost;
}

// Squared change of angles; a hinge without limits may go the short way round.
double ChangeCost(const HingeChain& chain, const VectorXd& from,
                  const VectorXd& to) {
  double cost = 0;
  for (int i = 0; i < chain.size(); ++i) {
    const bool limited =
        std::isfinite(chain.lower[i]) && std::isfinite(chain.upper[i]);
    const double target = limited ? to[i] : motion::Unwrap(to[i], from[i]);
    cost += (target - from[i]) * (target - from[i]);
  }
  return cost;
}

// Cheapest path through the candidates that starts with candidate `first`.
struct Path {
  double cost = std::numeric_limits<double>::infinity();
  std::vector<int> choice;
};

Path CheapestPath(const HingeChain& chain,
                  const std::vector<Series>& candidates, int first,
                  bool loops) {
  const int frames = static_cast<int>(candidates.size());
  std::vector<std::vector<int>> before(frames);
  std::vector<double> cost(candidates[0].size(),
                           std::numeric_limits<double>::infinity());
  cost[first] = LimitCost(chain, candidates[0][first]);
  for (int t = 1; t < frames; ++t) {
    std::vector<double> next;
    for (const VectorXd& to : candidates[t]) {
      int best = 0;
      double best_cost = std::numeric_limits<double>::infinity();
      for (size_t c = 0; c < cost.size(); ++c) {
        const double total =
            cost[c] + ChangeCost(chain, candidates[t - 1][c], to);
        if (total < best_cost) {
          best_cost = total;
          best = static_cast<int>(c);
        }
      }
      before[t].push_back(best);
      next.push_back(best_cost + LimitCost(chain, to));
    }
    cost = std::move(next);
  }
  if (loops) {
    for (size_t c = 0; c < cost.size(); ++c) {
      cost[c] +=
          ChangeCost(chain, candidates[frames - 1][c], candidates[0][first]);
    }
  }
  Path path;
  const auto best = std::min_element(cost.begin(), cost.end());
  path.cost = *best;
  path.choice.assign(frames, static_cast<int>(best - cost.begin()));
  for (int t = frames - 1; t > 0; --t) {
    path.choice[t - 1] = before[t][path.choice[t]];
  }
  return path;
}

Series ChooseBranches(const HingeChain& chain,
                      const std::vector<Quaterniond>& targets, bool loops) {
  std::vector<Series> candidates;
  for (const Quaterniond& target : targets) {
    candidates.push_back(chain.Solve(target));
  }
  Path best;
  for (size_t first = 0; first < candidates[0].size(); ++first) {
    Path path = CheapestPath(chain, candidates, static_cast<int>(first), loops);
    if (best.choice.empty() || path.cost < best.cost) best = std::move(path);
  }
  Series angles;
  for (size_t t = 0; t < targets.size(); ++t) {
    angles.push_back(candidates[t][best.choice[t]]);
    for (int i = 0; t > 0 && i < chain.size(); ++i) {
      if (std::isfinite(chain.lower[i]) && std::isfinite(chain.upper[i])) {
        continue;
      }
      angles[t][i] = motion::Unwrap(angles[t][i], angles[t - 1][i]);
    }
  }
  return angles;
}

// The least-squares problem of step 3 around the present angles.
class Refinement {
 public:
  Refinement(const HingeChain& chain, const std::vector<Quaterniond>& targets,
             bool loops)
      : chain_(chain), targets_(targets), loops_(loops) {}

  // Half the sum of squares.
  double Cost(const Series& angles) const {
    double cost = 0;
    for (int t = 0; t < frames(); ++t) {
      cost += Error(angles, t).squaredNorm() +
              kLimit * kLimit * LimitCost(chain_, angles[t]);
      ForEachDifference(t, [&](const Difference& d) {
        cost += d.weight * d.weight * d.Apply(angles).squaredNorm();
      });
    }
    return cost / 2;
  }

  // One step with damping; the result is to be accepted if the cost fell.
  Series Step(const Series& angles, double damping) const {
    const int k = chain_.size();
    std::vector<Eigen::Triplet<double>> entries;
    VectorXd gradient = VectorXd::Zero(frames() * k);
    for (int t = 0; t < frames(); ++t) {
      AddRotation(angles, t, damping, &entries, &gradient);
      ForEachDifference(t, [&](const Difference& d) {
        AddDifference(d, angles, &entries, &gradient);
      });
    }
    Eigen::SparseMatrix<double> hessian(frames() * k, frames() * k);
    hessian.setFromTriplets(entries.begin(), entries.end());
    const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> solver(hessian);
    const VectorXd step = solver.solve(-gradient);
    Series result = angles;
    for (int t = 0; t < frames(); ++t) result[t] += step.segment(t * k, k);
    return result;
  }

 private:
  // weight * sum of coefficient * angles[frame].
  struct Difference {
    double weight;
    int frames[3];
    double coefficients[3];
    VectorXd Apply(const Series& angles) const {
      return coefficients[0] * angles[frames[0]] +
             coefficients[1] * angles[frames[1]] +
             coefficients[2] * angles[frames[2]];
    }
  };

  int frames() const { return static_cast<int>(targets_.size()); }

  // Rotation from the fitted to the wanted rotation, in the parent's frame.
  Eigen::Vector3d Error(const Series& angles, int t) const {
    return motion::Log(targets_[t] * chain_.Rotation(angles[t]).conjugate());
  }

  template <typename Visit>
  void ForEachDifference(int t, const Visit& visit) const {
    const int n = frames();
    const int before = t > 0 ? t - 1 : (loops_ ? n - 1 : -1);
    const int after = t + 1 < n ? t + 1 : (loops_ ? 0 : -1);
    if (after >= 0) {
      visit(Difference{kVelocity, {t, after, t}, {-1, 1, 0}});
    }
    if (after >= 0 && before >= 0) {
      visit(Difference{kAcceleration, {before, t, after}, {1, -2, 1}});
    }
  }

  void AddRotation(const Series& angles, int t, double damping,
                   std::vector<Eigen::Triplet<double>>* entries,
                   VectorXd* gradient) const {
    const int k = chain_.size();
    const Eigen::Matrix3Xd jacobian = chain_.Jacobian(angles[t]);
    MatrixXd block = jacobian.transpose() * jacobian;
    VectorXd slope = -jacobian.transpose() * Error(angles, t);
    const double weight = kLimit * kLimit;
    for (int i = 0; i < k; ++i) {
      const double excess =
          Excess(angles[t][i], chain_.lower[i], chain_.upper[i]);
      if (excess != 0) block(i, i) += weight;
      slope[i] += weight * excess;
      block(i, i) += damping;
    }
    for (int i = 0; i < k; ++i) {
      for (int j = 0; j < k; ++j) {
        entries->emplace_back(t * k + i, t * k + j, block(i, j));
      }
    }
    gradient->segment(t * k, k) += slope;
  }

  void AddDifference(const Difference& d, const Series& angles,
                     std::vector<Eigen::Triplet<double>>* entries,
                     VectorXd* gradient) const {
    const int k = chain_.size();
    const double weight = d.weight * d.weight;
    const VectorXd value = d.Apply(angles);
    for (int a = 0; a < 3; ++a) {
      gradient->segment(d.frames[a] * k, k) +=
          weight * d.coefficients[a] * value;
      for (int b = 0; b < 3; ++b) {
        for (int i = 0; i < k; ++i) {
          entries->emplace_back(d.frames[a] * k + i, d.frames[b] * k + i,
                                weight * d.coefficients[a] * d.coefficients[b]);
        }
      }
    }
  }

  const HingeChain& chain_;
  const std::vector<Quaterniond>& targets_;
  const bool loops_;
};

// Levenberg-Marquardt: damping falls on success and rises on failure.
Series Refine(const Refinement& problem, Series angles) {
  double damping = 1e-6;
  double cost = problem.Cost(angles);
  for (int i = 0; i < kSteps && damping < 1e6; ++i) {
    Series next = problem.Step(angles, damping);
    const double next_cost = problem.Cost(next);
    if (!(next_cost < cost)) {
      damping *= 10;
      continue;
    }
    const bool converged = cost - next_cost < 1e-9 * cost;
    angles = std::move(next);
    cost = next_cost;
    damping = std::max(damping / 10, 1e-9);
    if (converged) break;
  }
  return angles;
}

}  // namespace

Series FitJoints(const HingeChain& chain,
                 const std::vector<Quaterniond>& targets, bool loops,
                 int* cut) {
  SINEW_CHECK(targets.size() >= 2) << "targets " << targets.size();
  Series angles = ChooseBranches(chain, targets, loops);
  if (chain.size() == 0) return angles;
  angles = Refine(Refinement(chain, targets, loops), std::move(angles));
  // The fit weighs an angle beyond a limit against the rotation's error, so it
  // goes there only by this share of what is asked.
  const double share = 1 / (1 + kLimit * kLimit);
  for (VectorXd& frame : angles) {
    for (int i = 0; i < chain.size(); ++i) {
      const double excess = Excess(frame[i], chain.lower[i], chain.upper[i]);
      if (cut != nullptr) *cut += std::abs(excess) > share * kCutTolerance;
      frame[i] = std::clamp(frame[i], chain.lower[i], chain.upper[i]);
    }
  }
  return angles;
}

}  // namespace sinew::import
