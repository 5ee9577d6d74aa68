#ifndef SINEW_LEARNER_UPDATE_TRAINING_GRAPH_H_
#define SINEW_LEARNER_UPDATE_TRAINING_GRAPH_H_

#include <cstdint>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "proto/sinew/v1/graph.pb.h"

namespace sinew::learner {

// What learning differentiates, made of the graphs that act.
//
// Pure functions: thread-safe, never blocking. Errors: NOT_FOUND or
// INVALID_ARGUMENT naming graph and value.

// A graph of PolicyGraph that computes all that a loss reads of the policy at
// once.
struct TrainingGraph {
  v1::PolicyGraph all;  // with the graph `name` among the others
  std::string name;
  std::string noise;  // input with the latent's noise; empty: no latent
  // Nodes: the action's mean; then, with a latent, posterior mean and log
  // variance, prior mean and log variance.
  std::vector<std::string> outputs;
  int64_t observation_width = 0;
  int64_t action_width = 0;
  int64_t latent_width = 0;  // 0: no latent
};

// With a graph "prior" (common/policy/latent_builder.h): graph "policy" and,
// beside it, that of the prior, fed with the first columns of the observation;
// its nodes get "prior/" before their names. Else: graph "policy" as it is.
// Both are read at its tap "mean": where the policy explores, without that.
absl::StatusOr<TrainingGraph> MakeTrainingGraph(const v1::PolicyGraph& graph);

// The tracking policy of common/policy/builder.h with neither exploration nor
// critic: the tap "action" is the mean. For students without a latent, in whose
// training the student acts as it will in evaluations.
absl::StatusOr<v1::PolicyGraph> WithoutExploration(
    const v1::PolicyGraph& graph);

}  // namespace sinew::learner

#endif  // SINEW_LEARNER_UPDATE_TRAINING_GRAPH_H_
