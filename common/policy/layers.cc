#include "common/policy/layers.h"

#include <cmath>
#include <vector>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "common/policy/graph_error.h"
#include "common/policy/orthogonal.h"
#include "common/random/philox.h"
#include "common/status_macros.h"

namespace sinew::policy::internal {
namespace {

HostTensor Constant(const std::vector<int64_t>& shape, double value) {
  HostTensor tensor = HostTensor::Zeros(shape);
  for (float& element : tensor.mutable_float32()) {
    element = static_cast<float>(value);
  }
  return tensor;
}

}  // namespace

absl::StatusOr<v1::Op> ActivationOp(v1::Network::Activation activation) {
  switch (activation) {
    case v1::Network::ACTIVATION_SILU:
      return v1::OP_SILU;
    case v1::Network::ACTIVATION_RELU:
      return v1::OP_RELU;
    case v1::Network::ACTIVATION_ELU:
      return v1::OP_ELU;
    case v1::Network::ACTIVATION_TANH:
      return v1::OP_TANH;
    default:
      return Bad("network.activation: expected SILU, RELU, ELU or TANH, found ",
                 static_cast<int>(activation));
  }
}

absl::Status CheckPositive(absl::string_view name, double value) {
  if (value > 0 && std::isfinite(value)) return absl::OkStatus();
  return Bad(name, ": expected > 0, found ", value);
}

absl::Status CheckWidth(absl::string_view name, int64_t width) {
  if (width >= 1) return absl::OkStatus();
  return Bad(name, ": expected >= 1, found ", width);
}

absl::Status CheckWidths(absl::string_view name,
                         absl::Span<const int32_t> widths) {
  for (const int32_t width : widths) {
    SINEW_RETURN_IF_ERROR(CheckWidth(name, width));
  }
  return absl::OkStatus();
}

Value AddNormalised(const Value& input, const std::string& nodes,
                    const std::string& parameters, double clip,
                    GraphWriter& writer) {
  const std::string mean = parameters + "mean";
  const std::string inverse_std = parameters + "inverse_std";
  writer.Parameter(mean, {input.width}, /*frozen=*/true);
  writer.Parameter(inverse_std, {input.width}, /*frozen=*/true);
  const std::string normalised = nodes + "normalised";
  writer.Node(normalised, v1::OP_NORMALISE, {input.name}, {mean, inverse_std});
  const Value clipped = {.name = nodes + "clipped", .width = input.width};
  v1::Node& clamp = writer.Node(clipped.name, v1::OP_CLAMP, {normalised});
  clamp.set_low(-clip);
  clamp.set_high(clip);
  return clipped;
}

Value AddHidden(const Value& input, const HiddenLayers& hidden,
                GraphWriter& writer) {
  Value value = input;
  for (size_t i = 0; i < hidden.widths.size(); ++i) {
    const std::string name = absl::StrCat(hidden.nodes, "hidden_", i);
    const int64_t width = hidden.widths[i];
    writer.Linear(name, value.name, absl::StrCat(hidden.layers, "/linear_", i),
                  {width, value.width}, hidden.frozen);
    value = {.name = name + "_activation", .width = width};
    writer.Node(value.name, hidden.activation, {name});
  }
  return value;
}

void AddExploration(const std::string& noise, int64_t width,
                    GraphWriter& writer) {
  constexpr char kStd[] = "policy/std";
  writer.Input(noise, width, v1::GraphInput::KIND_NORMAL);
  writer.Parameter(kStd, {width}, /*frozen=*/true);
  writer.Node("exploration", v1::OP_AFFINE, {noise}, {kStd});
  writer.Node("action", v1::OP_ADD, {"mean", "exploration"});
  v1::Tap& action = writer.Tap("action", "action");
  action.set_executed(true);
  action.set_recorded(true);
  action.mutable_gaussian()->set_mean("mean");
  action.mutable_gaussian()->set_std_parameter(kStd);
  writer.Tap("mean", "mean").set_recorded(true);
}

TensorMap DrawWeights(const v1::PolicyGraph& graph, uint64_t seed,
                      const WeightRule& rule) {
  TensorMap weights;
  for (int i = 0; i < graph.parameters_size(); ++i) {
    const v1::Parameter& parameter = graph.parameters(i);
    const std::string& name = parameter.name();
    const std::vector<int64_t> shape(parameter.shape().begin(),
                                     parameter.shape().end());
    if (absl::EndsWith(name, "/weight") && !parameter.frozen()) {
      const RandomKey key = {.seed = seed,
                             .environment = static_cast<uint64_t>(i),
                             .purpose = RandomPurpose::kInitialisation};
      weights[name] =
          OrthogonalWeight(shape[0], shape[1], rule.gain(name), key);
    } else {
      weights[name] = Constant(shape, rule.constant(name));
    }
  }
  return weights;
}

}  // namespace sinew::policy::internal
