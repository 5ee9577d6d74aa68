#include "sim/import/retarget/pose_fit.h"

#include <cmath>

#include "sim/import/retarget/normal_equations.h"
#include "sim/import/retarget/pose_terms.h"

namespace sinew::import {
namespace {

using Eigen::VectorXd;

constexpr double kFirstDamping = 1e-3;
constexpr double kMostDamping = 1e4;

}  // namespace

ModelMotion FitPoses(const RoleTrack& track, const BodyMap& map,
                     const ScaledSource& wanted,
                     const std::vector<std::vector<Lock>>& locks,
                     const ModelMotion& motion, Dynamics* dynamics,
                     const PoseFitOptions& options) {
  const mjModel& model = dynamics->model();
  const int frames = motion.frames();
  const PoseTerms terms(track, map, wanted, locks, motion, dynamics, options);
  ModelMotion best = motion;
  ModelMotion next = motion;
  double best_cost = INFINITY;
  double damping = kFirstDamping;
  std::vector<VectorXd> step;
  NormalEquations equations(frames, model.nv, /*ring=*/false);
  // Each round measures the last step's cost with the equations of the next
  // one; a step that cost more is taken back and made shorter.
  for (int i = 0; i <= options.iterations && damping < kMostDamping; ++i) {
    equations.Clear();
    const double cost = terms.Linearise(next, damping, &equations);
    if (cost < best_cost) {
      best_cost = cost;
      best = next;
      if (i == options.iterations) break;
      step = equations.Solve(/*damping=*/0);
    } else {
      damping *= 10;
      for (VectorXd& s : step) s *= 0.3;
      next = best;
    }
    if (step.empty()) break;  // a first cost that is no number
    for (int t = 0; t < frames; ++t) {
      mj_integratePos(&model, next.qpos[t].data(), step[t].data(), 1);
    }
  }
  KeepCycle(motion.qpos[0].head<3>(), &best);
  ClampHinges(model, &best);
  return best;
}

}  // namespace sinew::import
