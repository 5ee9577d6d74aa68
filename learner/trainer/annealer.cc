#include "learner/trainer/annealer.h"

#include <algorithm>
#include <cmath>

namespace sinew::learner {
namespace {

// Survival must grow by this much to count as an improvement.
constexpr double kImprovement = 0.01;

}  // namespace

void Annealer::Observe(double success_share, double survived_share,
                       int64_t samples) {
  if (survived_share > state_.best_survival() + kImprovement) {
    state_.set_best_survival(survived_share);
    state_.set_stalled(0);
  } else {
    state_.set_stalled(state_.stalled() + 1);
  }
  if (state_.started()) return;
  const bool succeeded =
      recipe_.success_share() > 0 && success_share >= recipe_.success_share();
  const bool stalled = recipe_.stall_evaluations() > 0 &&
                       state_.stalled() >= recipe_.stall_evaluations();
  if (succeeded || stalled) Start(samples);
}

void Annealer::Advance(int64_t samples, int64_t iterations) {
  const auto reached = [](int64_t now, int64_t begin) {
    return begin > 0 && now >= begin;
  };
  if (reached(samples, recipe_.begin_samples()) ||
      reached(iterations, recipe_.begin_iteration())) {
    Start(samples);
  }
}

void Annealer::Start(int64_t samples) {
  if (state_.started()) return;
  state_.set_started(true);
  state_.set_start_samples(samples);
}

double Annealer::Progress(int64_t samples) const {
  if (!state_.started()) return 0;
  return std::clamp(static_cast<double>(samples - state_.start_samples()) /
                        static_cast<double>(recipe_.samples()),
                    0.0, 1.0);
}

double Annealer::StdFactor(int64_t samples) const {
  return std::pow(recipe_.std_factor(), Progress(samples));
}

double Annealer::LearningRateFactor(int64_t samples) const {
  return std::pow(recipe_.learning_rate_factor(), Progress(samples));
}

}  // namespace sinew::learner
