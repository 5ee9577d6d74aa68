#include "sim/import/retarget/refine.h"

#include <algorithm>
#include <utility>

#include "common/check.h"
#include "sim/import/retarget/refine_terms.h"
#include "sim/motion/rotation.h"

namespace sinew::import {
namespace {

using Eigen::VectorXd;

constexpr double kFirstDamping = 1e-4;
constexpr double kLeastDamping = 1e-6;
constexpr double kMostDamping = 1e3;
constexpr int kStalledSteps = 8;
// Frames that terms reach beyond one.
constexpr int kReachFrames = 2;

// Frames [begin, end) of a motion; of one that loops also beyond its end.
struct Window {
  int begin;
  int end;
  HeldFrames held;  // within
};

// Levenberg's damping rises until a step lowers the cost. Which points may bear
// is chosen anew after each step, which may raise the cost again and go back
// and forth for ever: some steps without a lower cost than ever before are the
// last.
ModelMotion Minimise(RefineTerms* terms, ModelMotion start,
                     const RefineOptions& options) {
  RefineState state = terms->Begin(std::move(start));
  NormalEquations equations = terms->MakeEquations();
  double damping = kFirstDamping;
  double least = state.cost;
  int stalled = 0;
  bool converged = false;
  for (int i = 0; i < options.iterations && !converged; ++i) {
    if (options.stop.stop_requested()) break;
    terms->Linearise(state, &equations);
    bool accepted = false;
    while (!accepted && damping < kMostDamping) {
      const std::vector<VectorXd> steps = equations.Solve(damping);
      damping *= 10;
      if (steps.empty()) continue;
      RefineState next = terms->Evaluate(terms->Moved(state, steps), state);
      accepted = next.cost < state.cost;
      if (!accepted) continue;
      damping = std::max(damping / 50, kLeastDamping);
      converged = state.cost - next.cost < options.converged * state.cost;
      state = std::move(next);
    }
    if (!accepted) break;
    terms->ChooseContacts(&state);
    stalled = state.cost < (1 - options.converged) * least ? 0 : stalled + 1;
    converged |= stalled >= kStalledSteps;
    least = std::min(least, state.cost);
  }
  return std::move(state.motion);
}

// First what makes it physical, then, from there, bodies apart as well: all at
// once it may end early, since which bodies meet changes from step to step.
ModelMotion Refined(Dynamics* dynamics, const ModelMotion& original,
                    const std::vector<std::vector<bool>>& bearing,
                    ModelMotion start, const RefineOptions& options,
                    HeldFrames held = {}) {
  RefineOptions without_self = options;
  without_self.self = 0;
  RefineTerms first(dynamics, original, bearing, without_self, held);
  ModelMotion motion = Minimise(&first, std::move(start), options);
  if (options.self == 0) return motion;
  RefineTerms all(dynamics, original, bearing, options, held);
  if (!all.BodiesMeet(motion)) return motion;
  return Minimise(&all, std::move(motion), options);
}

// The order of windows is that of frames. Around a loop the last one goes on
// over the seam to where the first one was not yet disturbed by its beginning.
std::vector<Window> MakeWindows(const ModelMotion& motion,
                                const RefineOptions& options) {
  const int frames = motion.frames();
  if (frames <= options.window) return {{0, frames, {}}};
  SINEW_CHECK(options.overlap >= 1 &&
              2 * options.overlap + kReachFrames < options.window)
      << "overlap " << options.overlap << " of windows of " << options.window;
  const int all = motion.loops ? frames + options.overlap : frames;
  std::vector<Window> windows;
  for (int begin = 0, end = 0; end < all; begin = end - options.overlap) {
    end = std::min(begin + options.window, all);
    Window window{begin, end, {}};
    if (begin > 0) window.held.before = kReachFrames;
    if (motion.loops && end == all) window.held.after = kReachFrames;
    window.begin -= window.held.before;
    window.end += window.held.after;
    windows.push_back(window);
  }
  return windows;
}

ModelMotion Cut(const ModelMotion& motion, const Window& window) {
  ModelMotion part;
  part.rate = motion.rate;
  for (int t = window.begin; t < window.end; ++t) {
    part.qpos.push_back(FrameAt(motion, t));
  }
  return part;
}

// Puts the free frames of a window back into the motion. Where one was seen a
// cycle later, a motion of two frames takes it back: the pivot of the cycle,
// and the frame. The cycle goes on to be the same map of the world about a new
// pivot.
void Paste(const ModelMotion& part, const Window& window, ModelMotion* motion) {
  const int frames = motion->frames();
  ModelMotion back;
  back.loops = true;
  back.cycle = motion->cycle;
  back.qpos = {motion->qpos[0], motion->qpos[0]};
  for (int t = window.begin + window.held.before;
       t < window.end - window.held.after; ++t) {
    const VectorXd& qpos = part.qpos[t - window.begin];
    if (t < frames) {
      motion->qpos[t] = qpos;
    } else {
      back.qpos[1] = qpos;
      motion->qpos[t - frames] = FrameAt(back, -1);
    }
  }
  KeepCycle(back.qpos[0].head<3>(), motion);
}

}  // namespace

ModelMotion RefineMotion(Dynamics* dynamics,
                         const std::vector<std::vector<bool>>& bearing,
                         const ModelMotion& original,
                         const RefineOptions& options) {
  if (original.frames() < 3) return original;
  ModelMotion motion = original;
  const std::vector<Window> windows = MakeWindows(original, options);
  if (windows.size() == 1) {
    motion = Refined(dynamics, original, bearing, original, options);
  } else {
    for (const Window& window : windows) {
      if (options.stop.stop_requested()) break;
      const ModelMotion part = Cut(original, window);
      std::vector<std::vector<bool>> bears;
      for (int t = window.begin; t < window.end; ++t) {
        bears.push_back(bearing[t % original.frames()]);
      }
      Paste(Refined(dynamics, part, bears, Cut(motion, window), options,
                    window.held),
            window, &motion);
    }
  }
  ClampHinges(dynamics->model(), &motion);
  return motion;
}

}  // namespace sinew::import
