#ifndef SINEW_LEARNER_TRAINER_ANNEALER_H_
#define SINEW_LEARNER_TRAINER_ANNEALER_H_

#include <cstdint>

#include "proto/sinew/v1/recipe.pb.h"
#include "proto/sinew/v1/training_state.pb.h"

namespace sinew::learner {

// Lowers noise and learning rates once evaluations say so, after so many
// samples or iterations, or when the trainer's plateau is reached (Start). From
// then on, x = min(1, samples since / anneal.samples) and each factor is
// final^x (geometric). It never stops once started.
//
// Thread-safety: one caller. Ownership: a value. Blocking: never. Errors: none.
class Annealer {
 public:
  explicit Annealer(const v1::Anneal& recipe) : recipe_(recipe) {}

  // Tells it an evaluation that took effect after `samples` samples: share of
  // starts that succeeded and share of frames survived.
  void Observe(double success_share, double survived_share, int64_t samples);
  // Tells it that so many samples have been learnt from in so many iterations.
  // Starts at the first call at or past anneal.begin_samples or
  // begin_iteration, if there is one.
  void Advance(int64_t samples, int64_t iterations);
  // Starts, unless it has started.
  void Start(int64_t samples);
  // Whether the factors are the final ones.
  bool Finished(int64_t samples) const { return Progress(samples) >= 1; }

  // Factors on the action's standard deviation and on learning rates.
  double StdFactor(int64_t samples) const;
  double LearningRateFactor(int64_t samples) const;

  const v1::AnnealState& state() const { return state_; }
  void Restore(const v1::AnnealState& state) { state_ = state; }
  // What comes is evaluated on another library: what the best survival was, and
  // for how long, is forgotten unless annealing has started.
  void Migrate() {
    if (!state_.started()) state_.Clear();
  }

 private:
  double Progress(int64_t samples) const;

  v1::Anneal recipe_;
  v1::AnnealState state_;
};

}  // namespace sinew::learner

#endif  // SINEW_LEARNER_TRAINER_ANNEALER_H_
