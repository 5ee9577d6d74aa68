#ifndef SINEW_ACTOR_POLICY_RUNNER_H_
#define SINEW_ACTOR_POLICY_RUNNER_H_

#include <memory>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/types/span.h"
#include "actor/prepared_snapshot.h"
#include "common/policy/executor.h"
#include "common/random/philox.h"

namespace sinew::actor {

// Runs a graph of a snapshot on a batch of observations.
//
// Use: SetGraph; then per step write observation rows and noise, Run, read
// rows. What a row gives depends on that row alone.
//
// Thread-safety: one caller. Ownership: keeps the graph's weights alive.
// Blocking: Run computes; only SetGraph with another graph allocates.
// Errors: SetGraph reports what the executor refuses.
class PolicyRunner {
 public:
  explicit PolicyRunner(int max_batch) : max_batch_(max_batch) {}

  absl::Status SetGraph(const ActingGraph& graph);

  // Row of the observation input, [O], to be written before Run.
  absl::Span<float> observation(int row) const;

  // Noise of one row, N(0, scale^2) by key over all noise inputs in graph
  // order; and none for all rows.
  void DrawNoise(int row, const RandomKey& key, double scale = 1);
  void ClearNoise();

  // Evaluates rows 0 .. batch-1.
  void Run(int batch) { executor_->Run(batch); }

  // [A] of the last Run.
  absl::Span<const float> action(int row) const;
  absl::Span<const float> mean(int row) const;
  // The latent that it was decoded from, and the noise in that latent; each
  // empty unless the graph has a tap for it.
  absl::Span<const float> latent(int row) const;
  absl::Span<const float> latent_noise(int row) const;

  // Natural logarithm of the density of action(row) under N(mean, std^2),
  // computed in float64:
  //   -1/2 sum ((a - mean) / std)^2 - sum ln std - A/2 ln 2 pi
  // 0 if the action has no distribution. With a latent, that given its noise.
  double LogProbability(int row) const;

 private:
  struct Rows {
    absl::Span<float> values;
    size_t width = 0;
  };
  absl::Status Bind(const PolicyPorts& ports);
  absl::Span<const float> Row(int tap, size_t width, int row) const;

  int max_batch_;
  std::unique_ptr<policy::Executor> executor_;
  Rows observation_;
  std::vector<Rows> noise_;
  std::vector<float> draw_;  // one row of all noise inputs
  int action_tap_ = -1;
  int mean_tap_ = -1;
  int latent_tap_ = -1, latent_noise_tap_ = -1;  // -1: the graph has none
  size_t action_width_ = 0;
  size_t latent_width_ = 0, latent_noise_width_ = 0;
  std::vector<double> std_;
  double log_normaliser_ = 0;  // sum ln std + A/2 ln 2 pi
};

}  // namespace sinew::actor

#endif  // SINEW_ACTOR_POLICY_RUNNER_H_
