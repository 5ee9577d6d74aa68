#include "learner/trainer/plateau.h"

namespace sinew::learner {

void Plateau::Observe(double share, int64_t samples) {
  if (!enabled() || reached() || samples < recipe_.min_samples()) return;
  if (!state_.started() || share > state_.best_share() + recipe_.gain()) {
    state_.set_started(true);
    state_.set_best_share(share);
    state_.set_stalled(0);
    return;
  }
  state_.set_stalled(state_.stalled() + 1);
  state_.set_reached(state_.stalled() >= recipe_.evaluations());
}

}  // namespace sinew::learner
