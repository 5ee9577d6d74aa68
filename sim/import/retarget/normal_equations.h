#ifndef SINEW_SIM_IMPORT_RETARGET_NORMAL_EQUATIONS_H_
#define SINEW_SIM_IMPORT_RETARGET_NORMAL_EQUATIONS_H_

#include <Eigen/Dense>
#include <vector>

#include "absl/types/span.h"

namespace sinew::import {

// Part of a residual's Jacobian: its derivative by one frame's coordinates.
struct FrameBlock {
  int frame;
  Eigen::Ref<const Eigen::MatrixXd> jacobian;  // [rows, coordinates]
};

// Gauss-Newton normal equations of a least-squares problem over the frames of a
// clip, each with the same number of coordinates. Residuals touch frames at
// most two apart, on a line or around a ring; so the matrix is a band of dense
// blocks, and on a ring the last two frames are a border that every frame may
// touch. The order of frames is the order of elimination: what a frame's column
// of blocks holds at and below the diagonal is one panel,
//   [t; t+1; t+2; border; border]
// cut where the line ends.
//
// Thread-safety: one thread. Ownership: owns all storage, reused from problem
// to problem. Blocking: never. Errors: Solve reports a matrix that is not
// positive definite.
class NormalEquations {
 public:
  // Precondition: a ring has 3 frames or more.
  NormalEquations(int frames, int coordinates, bool ring);

  // Forgets all residuals.
  void Clear();

  // Adds a residual: gradient += J' r, matrix += J' J. Frames must differ.
  void Add(absl::Span<const FrameBlock> blocks,
           const Eigen::Ref<const Eigen::VectorXd>& residual);

  // For who adds products by himself. Part of the matrix, [coordinates,
  // coordinates], rows of one frame and columns of another; row >= column, at
  // most two apart, or the one a border. Of blocks on the diagonal only the
  // lower half counts.
  Eigen::Block<Eigen::MatrixXd> Block(int row, int column);
  // Part of the gradient, [coordinates].
  Eigen::VectorBlock<Eigen::VectorXd> Gradient(int frame);

  // [frames * coordinates], half the derivative of the sum of squares.
  const Eigen::VectorXd& gradient() const { return gradient_; }

  // The change of all coordinates, [frames][coordinates], that solves
  // (matrix + damping * (1 + diagonal)) x = -gradient; empty on failure.
  std::vector<Eigen::VectorXd> Solve(double damping);

 private:
  // Rows below the diagonal block of a panel: frames of the band, then border.
  int Followers(int frame) const;
  // First row of frame `row` in the panel of `column`.
  int Offset(int row, int column) const;
  bool Eliminate(int frame);
  // Row frames of a panel below its diagonal, in order.
  int Follower(int frame, int index) const;

  const int frames_;
  const int coordinates_;
  const int border_;  // first frame of the border; frames_ without
  // [frames] of [rows, coordinates].
  std::vector<Eigen::MatrixXd> panels_;
  std::vector<Eigen::MatrixXd> factor_;
  Eigen::VectorXd gradient_;
};

}  // namespace sinew::import

#endif  // SINEW_SIM_IMPORT_RETARGET_NORMAL_EQUATIONS_H_
