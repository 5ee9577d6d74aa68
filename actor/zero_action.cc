#include "actor/zero_action.h"

#include <utility>

#include "common/policy/builder.h"
#include "common/policy/safetensors.h"
#include "common/status_macros.h"

namespace sinew::actor {

absl::StatusOr<v1::Snapshot> ZeroActionSnapshot(int64_t observation_width,
                                                int64_t action_width,
                                                double std) {
  policy::TrackingPolicyOptions options;
  options.observation_width = observation_width;
  options.action_width = action_width;
  options.network.add_policy_hidden(1);
  options.network.add_value_hidden(1);
  options.network.set_activation(v1::Network::ACTIVATION_SILU);
  options.network.set_last_layer_gain(1);
  options.network.set_observation_clip(8);
  options.network.set_initial_std(std);
  v1::Snapshot snapshot;
  SINEW_ASSIGN_OR_RETURN(*snapshot.mutable_graph(),
                         policy::BuildTrackingPolicy(options));
  SINEW_ASSIGN_OR_RETURN(TensorMap weights,
                         policy::InitialWeights(options, /*seed=*/0));
  // A last layer of zeros (its bias is zero already).
  HostTensor& last = weights.at("policy/mean/weight");
  last = HostTensor::Zeros(last.shape);
  snapshot.set_weights(SerializeSafetensors(weights));
  return snapshot;
}

}  // namespace sinew::actor
