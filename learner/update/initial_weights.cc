#include "learner/update/initial_weights.h"

#include <set>
#include <utility>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "absl/strings/string_view.h"
#include "absl/strings/strip.h"
#include "common/policy/builder.h"
#include "common/policy/validate.h"
#include "common/status_macros.h"
#include "learner/update/widening.h"

namespace sinew::learner {
namespace {

constexpr char kStd[] = "policy/std";
constexpr char kWeights[] = "initial weights";

std::string Describe(const HostTensor& tensor) {
  return absl::StrCat(
      tensor.dtype == v1::DATA_TYPE_FLOAT32
          ? ""
          : absl::StrCat(v1::DataType_Name(tensor.dtype), " of "),
      "shape [", absl::StrJoin(tensor.shape, ", "), "]");
}

absl::Status Unfit(absl::string_view source, absl::string_view name,
                   absl::string_view expected, absl::string_view found) {
  return absl::InvalidArgumentError(absl::StrCat(
      source, ": tensor ", name, ": expected ", expected, ", found ", found));
}

absl::Status CheckShape(absl::string_view source, absl::string_view name,
                        const HostTensor& expected, const HostTensor& found) {
  if (found.dtype == expected.dtype && found.shape == expected.shape) {
    return absl::OkStatus();
  }
  return Unfit(source, name, Describe(expected), Describe(found));
}

// What the graph "policy" reads.
absl::StatusOr<std::set<std::string>> PolicyParameters(
    const v1::PolicyGraph& graph) {
  SINEW_ASSIGN_OR_RETURN(const v1::Graph* policy,
                         policy::FindGraph(graph, "policy"));
  std::set<std::string> names;
  for (const v1::Node& node : policy->nodes()) {
    names.insert(node.parameters().begin(), node.parameters().end());
  }
  names.erase(kStd);
  return names;
}

absl::Status CheckIsNoComposer(const Primitive& primitive) {
  for (const auto& [name, tensor] : primitive.weights) {
    if (!policy::IsComposerParameter(name)) continue;
    return absl::InvalidArgumentError(
        absl::StrCat(primitive.name,
                     ": expected a primitive, a policy of one network, found a "
                     "composer (tensor ",
                     name, ")"));
  }
  return absl::OkStatus();
}

absl::Status TakePrimitive(const Primitive& primitive, int number,
                           TensorMap& into) {
  SINEW_RETURN_IF_ERROR(CheckIsNoComposer(primitive));
  SINEW_RETURN_IF_ERROR(CheckFinite(primitive.weights, primitive.name));
  const std::string prefix = policy::PrimitiveParameter(number, "");
  std::set<std::string> taken = {kStd};
  for (auto& [name, tensor] : into) {
    absl::string_view own = name;
    if (!absl::ConsumePrefix(&own, prefix)) continue;
    const auto found = primitive.weights.find(std::string(own));
    if (found == primitive.weights.end()) {
      return Unfit(primitive.name, own, Describe(tensor), "none");
    }
    SINEW_RETURN_IF_ERROR(
        CheckShape(primitive.name, own, tensor, found->second));
    tensor = found->second;
    taken.insert(found->first);
  }
  for (const auto& [name, tensor] : primitive.weights) {
    if (taken.contains(name) || absl::StartsWith(name, "critic/")) continue;
    return Unfit(primitive.name, name, "none (layers of network.policy_hidden)",
                 Describe(tensor));
  }
  return absl::OkStatus();
}

// Primitives that a composer has room for.
int CountPrimitives(const TensorMap& composer) {
  int count = 0;
  while (
      composer.contains(policy::PrimitiveParameter(count, "normaliser/mean"))) {
    ++count;
  }
  return count;
}

}  // namespace

absl::Status TakeWeights(const v1::PolicyGraph& graph, const TensorMap& from,
                         TensorMap& into) {
  SINEW_RETURN_IF_ERROR(CheckFinite(from, kWeights));
  SINEW_ASSIGN_OR_RETURN(const std::set<std::string> needed,
                         PolicyParameters(graph));
  const HiddenWidths hidden(graph);
  TensorMap result = into;
  for (auto& [name, tensor] : result) {
    const auto found = from.find(name);
    if (name == kStd || found == from.end()) continue;
    if (hidden.CanWiden(name, found->second, tensor)) {
      Widen(found->second, tensor);
      continue;
    }
    SINEW_RETURN_IF_ERROR(CheckShape(kWeights, name, tensor, found->second));
    tensor = found->second;
  }
  for (const std::string& name : needed) {
    if (from.contains(name)) continue;
    return Unfit(kWeights, name, Describe(into.at(name)), "none");
  }
  into = std::move(result);
  return absl::OkStatus();
}

absl::Status TakePrimitives(absl::Span<const Primitive> primitives,
                            TensorMap& into) {
  const int expected = CountPrimitives(into);
  if (static_cast<int>(primitives.size()) != expected) {
    return absl::InvalidArgumentError(
        absl::StrCat("recipe field network.composer.primitives: expected ",
                     expected, " primitives, found ", primitives.size()));
  }
  TensorMap result = into;
  for (int k = 0; k < expected; ++k) {
    SINEW_RETURN_IF_ERROR(TakePrimitive(primitives[k], k, result));
  }
  for (const char* name : {"normaliser/mean", "normaliser/inverse_std"}) {
    result[name] = result.at(policy::PrimitiveParameter(0, name));
  }
  into = std::move(result);
  return absl::OkStatus();
}

}  // namespace sinew::learner
