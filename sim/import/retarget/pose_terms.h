#ifndef SINEW_SIM_IMPORT_RETARGET_POSE_TERMS_H_
#define SINEW_SIM_IMPORT_RETARGET_POSE_TERMS_H_

#include <Eigen/Dense>
#include <vector>

#include "sim/import/retarget/body_map.h"
#include "sim/import/retarget/dynamics.h"
#include "sim/import/retarget/foot_lock.h"
#include "sim/import/retarget/model_motion.h"
#include "sim/import/retarget/normal_equations.h"
#include "sim/import/retarget/pose_fit.h"
#include "sim/import/retarget/scaled_source.h"
#include "sim/import/retarget/self_contact.h"

namespace sinew::import {

// Frames [begin, begin + frames) of a motion; of one that loops they may go on
// over its seam.
struct PoseWindow {
  int begin = 0;
  int frames = 0;
};

// Whether what a fit changes goes on over the seam of a motion: it loops
// without turning.
bool GoesAround(const ModelMotion& motion);

// The least-squares problem behind FitPoses, of a window's frames; coordinates
// are the tangent of qpos.
//
// Thread-safety: one thread. Ownership: borrows all arguments.
class PoseTerms {
 public:
  PoseTerms(const RoleTrack& track, const BodyMap& map,
            const ScaledSource& wanted,
            const std::vector<std::vector<Lock>>& locks,
            const ModelMotion& original, const PoseWindow& window,
            Dynamics* dynamics, const PoseFitOptions& options);

  // Adds the normal equations around the window's poses `qpos`, damped, to
  // `equations`: on a line, a frame [nv] each. Returns the cost, the sum of
  // squares.
  double Linearise(const std::vector<Eigen::VectorXd>& qpos, double damping,
                   NormalEquations* equations) const;

  // The motion's frame that a frame of the window is.
  int At(int frame) const {
    return (window_.begin + frame) % original_.frames();
  }

 private:
  // One frame's normal equations in the making.
  struct Frame {
    Eigen::Block<Eigen::MatrixXd> matrix;  // lower half
    Eigen::VectorBlock<Eigen::VectorXd> slope;
    double cost = 0;
    // Adds residual r with derivative `jacobian`, [rows, nv], times weight.
    void Add(const Eigen::Ref<const Eigen::MatrixXd>& jacobian,
             const Eigen::Ref<const Eigen::VectorXd>& r, double weight);
    void AddScalar(int coordinate, double r, double weight);
  };

  // `t` is the motion's frame.
  void AddPoints(int t, Frame* frame) const;
  void AddRotations(int t, Frame* frame) const;
  void AddSoles(int t, Frame* frame) const;
  void AddSelf(Frame* frame) const;
  void AddHinges(const Eigen::VectorXd& qpos, const Eigen::VectorXd& change,
                 Frame* frame) const;
  double AddSmoothness(const std::vector<Eigen::VectorXd>& change,
                       NormalEquations* equations) const;

  const RoleTrack& track_;
  const BodyMap& map_;
  const ScaledSource& wanted_;
  const std::vector<std::vector<Lock>>& locks_;
  const ModelMotion& original_;
  const PoseWindow window_;
  Dynamics* const dynamics_;
  const PoseFitOptions options_;
  const SelfContacts self_contacts_;
  const int nv_;
  std::vector<double> point_weights_;     // [BodyMap::points]
  std::vector<double> rotation_weights_;  // [BodyMap::bodies]
  Eigen::VectorXd keep_weights_;          // [nv]
  Eigen::VectorXd change_weights_;        // [nv]
};

}  // namespace sinew::import

#endif  // SINEW_SIM_IMPORT_RETARGET_POSE_TERMS_H_
