#ifndef SINEW_LEARNER_PPO_SYNTHETIC_SEGMENTS_H_
#define SINEW_LEARNER_PPO_SYNTHETIC_SEGMENTS_H_

#include <cstdint>
#include <vector>

#include "common/policy/safetensors.h"
#include "proto/sinew/v1/graph.pb.h"
#include "proto/sinew/v1/rollout.pb.h"

namespace sinew::learner {

// A made-up problem for tests and benchmarks, which PPO solves in seconds: in
// every step an observation is drawn from N(shift, scale^2), the right action
// is f(observation) = tanh(W observation') with a fixed W and the standardised
// observation', and the reward is exp(-|action - f|^2 / 2). Episodes end at
// random: some terminate, some are truncated. Column "target" holds f, so the
// error of a policy can be read off.
struct SyntheticProblem {
  uint64_t seed = 1;
  int64_t observation_width = 6;
  int64_t action_width = 3;
  int64_t latent_width = 0;  // of a policy whose latent PPO learns; 0: none
  int orders = 8;
  int environments = 8;  // per order
  int steps = 32;
  double terminated_share = 0.02;
  double truncated_share = 0.03;
  double invalid_share = 0;  // diverged: also terminated, reward 0
};

// What actors would send for one iteration, acting with the graph "policy"
// through the Eigen executor: one segment per order, a function of all
// arguments. Aborts if the graph does not fit the problem.
std::vector<v1::Segment> MakeSyntheticSegments(const SyntheticProblem& problem,
                                               const v1::PolicyGraph& graph,
                                               const TensorMap& weights,
                                               int64_t iteration);

std::vector<const v1::Segment*> Pointers(
    const std::vector<v1::Segment>& segments);

// Mean over rows and actions of (action_mean - f)^2.
double MeanActionError(const std::vector<v1::Segment>& segments);

}  // namespace sinew::learner

#endif  // SINEW_LEARNER_PPO_SYNTHETIC_SEGMENTS_H_
