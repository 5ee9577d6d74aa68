#ifndef SINEW_SIM_IMPORT_RETARGET_NORMAL_EQUATIONS_H_
#define SINEW_SIM_IMPORT_RETARGET_NORMAL_EQUATIONS_H_

#include <Eigen/Dense>
#include <map>
#include <utility>
#include <vector>

#include "absl/types/span.h"

namespace sinew::import {

// Part of a residual's Jacobian: its derivative by one frame's coordinates.
struct FrameBlock {
  int frame;
  Eigen::MatrixXd jacobian;  // [rows, coordinates]
};

// Gauss-Newton normal equations of a least-squares problem over the frames of a
// clip, each with the same number of coordinates, kept as dense blocks of pairs
// of frames: residuals touch few neighbouring frames.
//
// Thread-safety: one thread. Errors: Solve reports a matrix that is not
// positive definite.
class NormalEquations {
 public:
  NormalEquations(int frames, int coordinates);

  // Adds a residual: gradient += J' r, matrix += J' metric J. The metric is the
  // identity unless part of the residual follows by itself (variable
  // projection).
  void Add(absl::Span<const FrameBlock> blocks,
           const Eigen::VectorXd& residual);
  void Add(absl::Span<const FrameBlock> blocks,
           const Eigen::VectorXd& residual, const Eigen::MatrixXd& metric);

  // Adds weight^2 (x_i + offset)^2 / 2 for one coordinate's change x_i.
  void AddScalar(int frame, int coordinate, double weight, double offset);

  // [frames * coordinates], half the derivative of the sum of squares.
  const Eigen::VectorXd& gradient() const { return gradient_; }

  // The change of all coordinates, [frames][coordinates], that solves
  // (matrix + damping * (1 + diagonal)) x = -gradient; empty on failure.
  std::vector<Eigen::VectorXd> Solve(double damping) const;

 private:
  Eigen::MatrixXd& Block(int row, int column);

  const int frames_;
  const int coordinates_;
  // Blocks on and below the diagonal, by (row frame, column frame).
  std::map<std::pair<int, int>, Eigen::MatrixXd> blocks_;
  Eigen::VectorXd gradient_;
};

}  // namespace sinew::import

#endif  // SINEW_SIM_IMPORT_RETARGET_NORMAL_EQUATIONS_H_
