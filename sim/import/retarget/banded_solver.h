#ifndef SINEW_SIM_IMPORT_RETARGET_BANDED_SOLVER_H_
#define SINEW_SIM_IMPORT_RETARGET_BANDED_SOLVER_H_

#include <Eigen/Dense>
#include <array>
#include <vector>

namespace sinew::import {

// A symmetric positive definite system over the frames of a clip in which a
// frame meets no more than the two before it: dense square blocks at (t, t),
// (t, t - 1) and (t, t - 2), all of one size.
//
// Thread-safety: one thread. Errors: Solve returns false if the matrix is not
// positive definite.
class BandedSolver {
 public:
  // Frames before a frame that it may meet.
  static constexpr int kBand = 2;

  BandedSolver(int frames, int size);

  // The block of frames t and t - back, back in [0, kBand]; to be filled before
  // Solve, which overwrites it. Of diagonal blocks the lower half is read.
  Eigen::MatrixXd& block(int t, int back) { return blocks_[t][back]; }

  // Solves matrix * x = x in place, [frames] of [size].
  bool Solve(std::vector<Eigen::VectorXd>* x);

 private:
  std::vector<std::array<Eigen::MatrixXd, kBand + 1>> blocks_;
};

}  // namespace sinew::import

#endif  // SINEW_SIM_IMPORT_RETARGET_BANDED_SOLVER_H_
