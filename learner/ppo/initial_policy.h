#ifndef SINEW_LEARNER_PPO_INITIAL_POLICY_H_
#define SINEW_LEARNER_PPO_INITIAL_POLICY_H_

#include "absl/status/statusor.h"
#include "common/policy/safetensors.h"
#include "proto/sinew/v1/graph.pb.h"
#include "proto/sinew/v1/recipe.pb.h"

namespace sinew::learner {

// What a run of PPO begins with: graphs "policy" and "critic", and those of a
// latent where the recipe has one.
struct InitialPolicy {
  v1::PolicyGraph graph;
  TensorMap weights;
};

// Columns.
struct PolicyWidths {
  int observation = 0;
  int self_observation = 0;  // the leading ones of it; with a latent
  int action = 0;
};

// Drawn from the recipe's seed; `recipe` has its defaults filled and is valid.
// Pure. INVALID_ARGUMENT: widths that no graph has.
absl::StatusOr<InitialPolicy> MakeInitialPolicy(const v1::Recipe& recipe,
                                                const PolicyWidths& widths);

}  // namespace sinew::learner

#endif  // SINEW_LEARNER_PPO_INITIAL_POLICY_H_
