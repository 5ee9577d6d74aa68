#include "sim/import/retarget/pose_fit.h"

#include <algorithm>
#include <cmath>

#include "common/check.h"
#include "sim/import/retarget/normal_equations.h"
#include "sim/import/retarget/pose_terms.h"

namespace sinew::import {
namespace {

using Eigen::VectorXd;

constexpr double kFirstDamping = 1e-3;
constexpr double kMostDamping = 1e4;

// The last window of a clip whose changes go on over its seam ends `overlap`
// frames beyond it, and is the only one that passes it.
std::vector<PoseWindow> MakeWindows(const ModelMotion& motion,
                                    const PoseFitOptions& options) {
  const int frames = motion.frames();
  if (frames <= options.window) return {{.begin = 0, .frames = frames}};
  SINEW_CHECK(options.overlap >= 1 && 2 * options.overlap < options.window)
      << "overlap " << options.overlap << " of windows of " << options.window;
  const int all = GoesAround(motion) ? frames + options.overlap : frames;
  std::vector<PoseWindow> windows;
  for (int begin = 0, end = 0; end < all; begin = end - options.overlap) {
    end = std::min(begin + options.window, all);
    if (all - end <= options.overlap) end = all;
    windows.push_back({.begin = begin, .frames = end - begin});
  }
  return windows;
}

// The window's poses of `original`, fitted, [frames] of [nq]. Each round
// measures the last step's cost with the equations of the next one; a step that
// cost more is taken back and made shorter.
std::vector<VectorXd> FitWindow(const PoseTerms& terms,
                                const PoseWindow& window,
                                const ModelMotion& original,
                                const mjModel& model,
                                const PoseFitOptions& options) {
  std::vector<VectorXd> best, next;
  for (int i = 0; i < window.frames; ++i) {
    best.push_back(original.qpos[terms.At(i)]);
  }
  next = best;
  double best_cost = INFINITY;
  double damping = kFirstDamping;
  std::vector<VectorXd> step;
  NormalEquations equations(window.frames, model.nv, /*ring=*/false);
  for (int i = 0; i <= options.iterations && damping < kMostDamping; ++i) {
    if (options.stop.stop_requested()) break;
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
    for (int t = 0; t < window.frames; ++t) {
      mj_integratePos(&model, next[t].data(), step[t].data(), 1);
    }
  }
  return best;
}

// 0 before the overlap's frame 0, 1 after its last one.
double Share(int frame, int overlap) {
  const double x = (frame + 1.0) / (overlap + 1.0);
  return x * x * (3 - 2 * x);
}

// Puts a window's poses into `motion`, which has those of the windows before:
// where they overlap, what these end with goes over into what this one begins
// with, and beyond the seam of a loop what it ends with into the first one's.
void Paste(const std::vector<VectorXd>& fitted, const PoseWindow& window,
           const mjModel& model, int overlap, ModelMotion* motion) {
  const int frames = motion->frames();
  for (int i = 0; i < window.frames; ++i) {
    const int t = window.begin + i;
    double share = 1;
    if (window.begin > 0 && i < overlap) share = Share(i, overlap);
    if (t >= frames) share = 1 - Share(t - frames, overlap);
    VectorXd& qpos = motion->qpos[t % frames];
    if (share == 1) {
      qpos = fitted[i];
    } else {
      const VectorXd change = share * Displacement(model, qpos, fitted[i]);
      mj_integratePos(&model, qpos.data(), change.data(), 1);
    }
  }
}

}  // namespace

ModelMotion FitPoses(const RoleTrack& track, const BodyMap& map,
                     const ScaledSource& wanted,
                     const std::vector<std::vector<Lock>>& locks,
                     const ModelMotion& motion, Dynamics* dynamics,
                     const PoseFitOptions& options) {
  const mjModel& model = dynamics->model();
  ModelMotion result = motion;
  for (const PoseWindow& window : MakeWindows(motion, options)) {
    if (options.stop.stop_requested()) break;
    const PoseTerms terms(track, map, wanted, locks, motion, window, dynamics,
                          options);
    Paste(FitWindow(terms, window, motion, model, options), window, model,
          options.overlap, &result);
  }
  KeepCycle(motion.qpos[0].head<3>(), &result);
  ClampHinges(model, &result);
  return result;
}

}  // namespace sinew::import
