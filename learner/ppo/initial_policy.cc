#include "learner/ppo/initial_policy.h"

#include "common/config/recipe.h"
#include "common/policy/builder.h"
#include "common/policy/latent_builder.h"
#include "common/status_macros.h"

namespace sinew::learner {

absl::StatusOr<InitialPolicy> MakeInitialPolicy(const v1::Recipe& recipe,
                                                const PolicyWidths& widths) {
  InitialPolicy initial;
  if (RecordedLatentWidth(recipe) > 0) {
    const policy::LatentPolicyOptions network = {
        .self_observation_width = widths.self_observation,
        .observation_width = widths.observation,
        .action_width = widths.action,
        .network = recipe.network(),
        .explores = true};
    SINEW_ASSIGN_OR_RETURN(initial.graph, policy::BuildLatentPolicy(network));
    SINEW_ASSIGN_OR_RETURN(
        initial.weights, policy::InitialLatentWeights(network, recipe.seed()));
    return initial;
  }
  const policy::TrackingPolicyOptions network = {
      .observation_width = widths.observation,
      .action_width = widths.action,
      .network = recipe.network()};
  SINEW_ASSIGN_OR_RETURN(initial.graph, policy::BuildTrackingPolicy(network));
  SINEW_ASSIGN_OR_RETURN(initial.weights,
                         policy::InitialWeights(network, recipe.seed()));
  return initial;
}

}  // namespace sinew::learner
