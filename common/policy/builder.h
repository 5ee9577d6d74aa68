#ifndef SINEW_COMMON_POLICY_BUILDER_H_
#define SINEW_COMMON_POLICY_BUILDER_H_

#include <cstdint>
#include <string>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "common/policy/safetensors.h"
#include "proto/sinew/v1/graph.pb.h"
#include "proto/sinew/v1/recipe.pb.h"

namespace sinew::policy {

// The networks of the tracking task: what a recipe's Network message means.
// With O observation columns, A actions and hidden widths h_0 ... h_{n-1}:
//
// Graph "policy": inputs "observation" [O] (DATA) and "noise" [A] (NORMAL)
//   node                    op         inputs                 width
//   normalised              NORMALISE  observation            O
//   clipped                 CLAMP      normalised             O
//   hidden_i                LINEAR     clipped or the layer   h_i
//                                      before's activation
//   hidden_i_activation     SILU, ...  hidden_i               h_i
//   mean                    LINEAR     last activation        A
//   exploration             AFFINE     noise                  A
//   action                  ADD        mean, exploration      A
//   taps: "action" (executed, recorded, Gaussian around "mean" with
//   "policy/std") and "mean" (recorded). Noise 0 gives action == mean.
// Graph "critic": input "observation"
//   normalised, clipped as above, hidden_i, hidden_i_activation, value [1];
//   tap "value".
//
// Parameters (float32), F: frozen, not changed by gradients
//   normaliser/mean         [O]         0           F
//   normaliser/inverse_std  [O]         1           F
//   policy/linear_i/weight  [h_i, ...]  orthogonal, gain sqrt(2)
//   policy/linear_i/bias    [h_i]       0
//   policy/mean/weight      [A, ...]    orthogonal, gain last_layer_gain
//   policy/mean/bias        [A]         0
//   policy/std              [A]         initial_std F
//   critic/linear_i/weight, critic/linear_i/bias   as in the policy
//   critic/value/weight     [1, ...]    orthogonal, gain 1
//   critic/value/bias       [1]         0
//
// With network.composer of K primitives and hidden widths c_j, "mean" of the
// graph "policy" is another node, and the rest stays as it is:
//
//   normalised, clipped, hidden_j, hidden_j_activation as above, of widths c_j
//   weights                 LINEAR     last activation        K
//   primitive_k/...         normalised to mean as above, of policy_hidden, for
//                           k = 0 ... K - 1
//   mean                    WEIGHTED_SUM  weights, primitive_0/mean, ...   A
//   further tap: "composer_weights", the value of "weights"
//
//   composer/linear_j/weight, composer/linear_j/bias   as in the policy
//   composer/weights/weight [K, ...]    orthogonal, gain last_layer_gain
//   composer/weights/bias   [K]         1 / K
//   primitive_k/NAME        as NAME     0           F; its inverse_std 1
//   with NAME = normaliser/mean, normaliser/inverse_std, policy/linear_i/...,
//   policy/mean/... of a policy without composer
//
// So a run begins close to the mean of its primitives, whose weights come from
// elsewhere; "normaliser/..." is the composer's and the critic's.
struct TrackingPolicyOptions {
  // Both >= 1.
  int64_t observation_width = 0;
  int64_t action_width = 0;
  // With defaults filled (common/config/recipe.h).
  v1::Network network{};
};

// Both graphs. INVALID_ARGUMENT names the option, expected and found.
//
// Thread-safety: pure functions. Blocking: InitialWeights computes for a
// fraction of a second.
absl::StatusOr<v1::PolicyGraph> BuildTrackingPolicy(
    const TrackingPolicyOptions& options);

// The initial weights of the table above; a function of options and seed.
// Parameter number i of the graph draws from the key {seed, environment = i,
// purpose = kInitialisation}.
absl::StatusOr<TensorMap> InitialWeights(const TrackingPolicyOptions& options,
                                         uint64_t seed);

// Whether a parameter is one of the layers that weigh primitives: a policy that
// has one is a composer.
bool IsComposerParameter(absl::string_view name);

// The name that parameter `name` of a policy without composer has as a part of
// the composer's primitive number `primitive`.
std::string PrimitiveParameter(int primitive, absl::string_view name);

}  // namespace sinew::policy

#endif  // SINEW_COMMON_POLICY_BUILDER_H_
