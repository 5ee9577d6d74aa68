#ifndef SINEW_COMMON_POLICY_LAYERS_H_
#define SINEW_COMMON_POLICY_LAYERS_H_

#include <cstdint>
#include <functional>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "absl/types/span.h"
#include "common/policy/graph_writer.h"
#include "common/policy/safetensors.h"
#include "proto/sinew/v1/graph.pb.h"
#include "proto/sinew/v1/recipe.pb.h"

namespace sinew::policy::internal {

// What the builders of graphs have in common: pieces of networks, checks of
// their options, initial weights.
//
// Thread-safety: pure, but for the writer's graph. Ownership: none. Blocking:
// DrawWeights computes for a fraction of a second. Errors: INVALID_ARGUMENT
// names the option, expected and found.

absl::StatusOr<v1::Op> ActivationOp(v1::Network::Activation activation);

// > 0 and finite.
absl::Status CheckPositive(absl::string_view name, double value);
// >= 1, of one or each of several.
absl::Status CheckWidth(absl::string_view name, int64_t width);
absl::Status CheckWidths(absl::string_view name,
                         absl::Span<const int32_t> widths);

// A node or input with its width.
struct Value {
  std::string name;
  int64_t width = 0;
};

// NODES + "normalised" and NODES + "clipped" (to +-clip) of `input`, with the
// frozen parameters PARAMETERS + "mean" and PARAMETERS + "inverse_std"; gives
// the latter node.
Value AddNormalised(const Value& input, const std::string& nodes,
                    const std::string& parameters, double clip,
                    GraphWriter& writer);

// Hidden layers: NODES + "hidden_i", then NODES + "hidden_i_activation", with
// parameters LAYERS/linear_i/...
struct HiddenLayers {
  absl::Span<const int32_t> widths;
  v1::Op activation = v1::OP_UNSPECIFIED;
  std::string nodes;
  std::string layers;
  bool frozen = false;
};
// The last of them, or `input` if there are none.
Value AddHidden(const Value& input, const HiddenLayers& hidden,
                GraphWriter& writer);

// Makes a Gaussian policy of the node "mean", [width]: an input `noise`
// (NORMAL) of that width, the frozen parameter "policy/std", nodes
// "exploration" (AFFINE of the noise by it) and "action" (ADD of both), taps
// "action" (executed, recorded, Gaussian) and "mean" (recorded).
void AddExploration(const std::string& noise, int64_t width,
                    GraphWriter& writer);

// What initial weights are made of.
struct WeightRule {
  // Gain of an orthogonal weight.
  std::function<double(const std::string& weight)> gain;
  // Of all elements of a parameter that is not drawn.
  std::function<double(const std::string& parameter)> constant;
};

// Initial weights of a graph: what is called .../weight and not frozen is
// orthogonal, the rest constant. Parameter number i of the graph draws from the
// key {seed, environment = i, purpose = kInitialisation}.
TensorMap DrawWeights(const v1::PolicyGraph& graph, uint64_t seed,
                      const WeightRule& rule);

}  // namespace sinew::policy::internal

#endif  // SINEW_COMMON_POLICY_LAYERS_H_
