#include "sim/import/retarget/refine.h"

#include <algorithm>

#include "sim/import/retarget/refine_terms.h"

namespace sinew::import {
namespace {

using Eigen::VectorXd;

// A step that lowers the cost by less than this share is the last one.
constexpr double kConverged = 1e-3;
constexpr double kMostDamping = 1e3;

ModelMotion Moved(const mjModel& model, ModelMotion motion,
                  const std::vector<VectorXd>& steps) {
  for (int t = 0; t < motion.frames(); ++t) {
    mj_integratePos(&model, motion.qpos[t].data(), steps[t].data(), 1);
  }
  return motion;
}

void ClampHinges(const ImportModel& model, ModelMotion* motion) {
  for (const ImportJoint& joint : model.joints) {
    const int id = model.model->dof_jntid[joint.dof_address];
    if (!model.model->jnt_limited[id]) continue;
    for (VectorXd& qpos : motion->qpos) {
      qpos[joint.qpos_address] =
          std::clamp(qpos[joint.qpos_address], model.model->jnt_range[2 * id],
                     model.model->jnt_range[2 * id + 1]);
    }
  }
}

}  // namespace

ModelMotion RefineMotion(Dynamics* dynamics,
                         const std::vector<std::vector<bool>>& bearing,
                         const ModelMotion& original,
                         const RefineOptions& options) {
  if (original.frames() < 3) return original;
  RefineTerms terms(dynamics, original, bearing, options);
  ModelMotion motion = original;
  double damping = 1e-4;
  bool converged = false;
  for (int i = 0; i < options.iterations && !converged; ++i) {
    terms.ChooseContacts(motion);
    const double cost = terms.Cost(motion);
    const NormalEquations equations = terms.Linearise(motion);
    bool accepted = false;
    while (!accepted && damping < kMostDamping) {
      const std::vector<VectorXd> steps = equations.Solve(damping);
      ModelMotion next =
          steps.empty() ? motion : Moved(dynamics->model(), motion, steps);
      const double next_cost = terms.Cost(next);
      accepted = next_cost < cost;
      damping = accepted ? std::max(damping / 5, 1e-6) : damping * 10;
      if (!accepted) continue;
      converged = cost - next_cost < kConverged * cost;
      motion = std::move(next);
    }
    converged |= !accepted;
  }
  ClampHinges(dynamics->import_model(), &motion);
  return motion;
}

}  // namespace sinew::import
