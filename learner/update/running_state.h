#ifndef SINEW_LEARNER_UPDATE_RUNNING_STATE_H_
#define SINEW_LEARNER_UPDATE_RUNNING_STATE_H_

#include <cstdint>

#include "absl/status/statusor.h"
#include "common/policy/safetensors.h"
#include "learner/update/normaliser.h"

namespace sinew::learner {

// What learners of all algorithms carry from update to update beside networks
// and optimisers.
struct RunningState {
  Moments moments;  // of all valid rows so far
  // By annealing.
  double std_factor = 1;
  double learning_rate_factor = 1;
};

// Into float64 tensors "normaliser_sums/mean", "normaliser_sums/squares" and
// "factors". The moments' count is a counter of TrainingState. Pure.
void SaveRunningState(const RunningState& state, TensorMap& tensors);

// The inverse, for observations of that width. INVALID_ARGUMENT names the
// tensor, expected and found. Pure.
absl::StatusOr<RunningState> LoadRunningState(const TensorMap& tensors,
                                              int64_t width, double count);

}  // namespace sinew::learner

#endif  // SINEW_LEARNER_UPDATE_RUNNING_STATE_H_
