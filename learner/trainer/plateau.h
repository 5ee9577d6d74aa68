#ifndef SINEW_LEARNER_TRAINER_PLATEAU_H_
#define SINEW_LEARNER_TRAINER_PLATEAU_H_

#include <cstdint>

#include "proto/sinew/v1/recipe.pb.h"
#include "proto/sinew/v1/training_state.pb.h"

namespace sinew::learner {

// Tells when evaluations have stopped improving. Those before min_samples do
// not count. The first that counts sets the best share; a later one that is
// above the best by more than `gain` sets it anew, every other one stalls. With
// `evaluations` stalled ones in a row the plateau is reached, for good. So a
// rise that is slow adds up: it counts once it is more than `gain` above the
// share that was the best when it last counted.
//
// Thread-safety: one caller. Ownership: a value. Blocking: never. Errors: none.
class Plateau {
 public:
  // Defaults filled; evaluations 0: it is never reached.
  explicit Plateau(const v1::Plateau& recipe) : recipe_(recipe) {}

  // Tells it an evaluation that took effect after `samples` samples: share of
  // the starts that succeeded, of clips that starts are drawn from.
  void Observe(double share, int64_t samples);

  // Whether the recipe has one.
  bool enabled() const { return recipe_.evaluations() > 0; }
  bool reached() const { return state_.reached(); }

  const v1::PlateauState& state() const { return state_; }
  void Restore(const v1::PlateauState& state) { state_ = state; }
  // What comes is evaluated on another library: all is forgotten.
  void Migrate() { state_.Clear(); }

 private:
  v1::Plateau recipe_;
  v1::PlateauState state_;
};

}  // namespace sinew::learner

#endif  // SINEW_LEARNER_TRAINER_PLATEAU_H_
