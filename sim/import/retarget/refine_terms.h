#ifndef SINEW_SIM_IMPORT_RETARGET_REFINE_TERMS_H_
#define SINEW_SIM_IMPORT_RETARGET_REFINE_TERMS_H_

#include <Eigen/Dense>
#include <vector>

#include "sim/import/retarget/contact_fit.h"
#include "sim/import/retarget/dynamics.h"
#include "sim/import/retarget/model_motion.h"
#include "sim/import/retarget/normal_equations.h"
#include "sim/import/retarget/refine.h"

namespace sinew::import {

// The least-squares problem behind RefineMotion. Every term knows its cost (the
// sum of squares) and its linearisation; coordinates are the tangent of qpos.
//
// Thread-safety: one thread. Ownership: borrows all arguments.
class RefineTerms {
 public:
  RefineTerms(Dynamics* dynamics, const ModelMotion& original,
              const std::vector<std::vector<bool>>& bearing,
              const RefineOptions& options);

  // Fixes, from the heights in `motion`, which points floor forces may act at
  // until the next call.
  void ChooseContacts(const ModelMotion& motion);

  double Cost(const ModelMotion& motion) const;
  NormalEquations Linearise(const ModelMotion& motion) const;

 private:
  // A frame near another one: where it is stored, and how its coordinates
  // appear there (the cycle turns the root's translation).
  struct Neighbour {
    int frame;
    Eigen::Matrix3d turn;
  };
  Neighbour Find(const ModelMotion& motion, int t) const;
  bool HasNeighbours(int t) const;

  Eigen::VectorXd Deviation(const ModelMotion& motion, int t) const;
  Eigen::VectorXd SecondDifference(const ModelMotion& motion, int t) const;
  ContactFit Contacts(const ModelMotion& motion, int t,
                      Eigen::VectorXd* qvel, Eigen::VectorXd* qacc) const;

  double PoseCost(const ModelMotion& motion, int t) const;
  double PointCost(const ModelMotion& motion, int t) const;
  void AddPose(const ModelMotion& motion, int t,
               NormalEquations* equations) const;
  void AddPoints(const ModelMotion& motion, int t,
                 NormalEquations* equations) const;
  void AddSlip(const ModelMotion& motion, int t,
               NormalEquations* equations) const;
  void AddSmoothness(const ModelMotion& motion, int t,
                     NormalEquations* equations) const;
  void AddPhysics(const ModelMotion& motion, int t,
                  NormalEquations* equations) const;
  bool Bears(int t, size_t point) const;

  Dynamics* const dynamics_;
  const ModelMotion& original_;
  const std::vector<std::vector<bool>>& bearing_;
  const RefineOptions options_;
  const int frames_;
  const int nv_;
  const Eigen::VectorXd pose_weights_;  // [nv]
  // [frames] second differences of the original; empty without neighbours.
  std::vector<Eigen::VectorXd> original_change_;
  std::vector<std::vector<int>> may_bear_;  // [frames] of points
};

}  // namespace sinew::import

#endif  // SINEW_SIM_IMPORT_RETARGET_REFINE_TERMS_H_
