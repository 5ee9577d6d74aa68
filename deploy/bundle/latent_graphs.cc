#include "deploy/bundle/latent_graphs.h"

#include <algorithm>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "common/config/recipe.h"
#include "common/files.h"
#include "common/policy/latent_graphs.h"
#include "common/policy/validate.h"
#include "common/status_macros.h"
#include "deploy/bundle/manifest.h"

namespace sinew::bundle {
namespace {

constexpr const char* kGraphs[] = {policy::kEncoderGraph, policy::kPriorGraph,
                                   policy::kDecoderGraph, policy::kSampleGraph};

// What a graph must have; each as Show prints it.
struct Wanted {
  const char* graph;
  std::set<std::string> inputs;
  std::map<std::string, std::string> taps;  // by name
};

// "latent [32]", "action [28] executed".
std::string Show(absl::string_view name, int64_t width,
                 absl::string_view kind = "") {
  return absl::StrCat(name, " [", width, "]", kind);
}

std::string ShowInput(const v1::GraphInput& input) {
  return Show(input.name(), input.width(),
              input.kind() == v1::GraphInput::KIND_DATA ? "" : " noise");
}

std::string ShowTap(const v1::Tap& tap, int64_t width) {
  return Show(tap.name(), width, tap.executed() ? " executed" : "");
}

std::vector<Wanted> WantedGraphs(const Bundle& bundle) {
  const v1::BundleManifest& manifest = bundle.manifest;
  const std::string observation =
      Show("observation", manifest.observation_width());
  const std::string own =
      Show("self_observation", manifest.self_observation_width());
  const int64_t z = LatentWidth(bundle.graph);
  const std::map<std::string, std::string> gaussian = {
      {"mean", Show("mean", z)}, {"std", Show("std", z)}};
  const std::map<std::string, std::string> action = {
      {"action", Show("action", manifest.action_width(), " executed")}};
  return {{policy::kEncoderGraph, {observation}, gaussian},
          {policy::kPriorGraph, {own}, gaussian},
          {policy::kDecoderGraph, {own, Show("latent", z)}, action},
          {policy::kSampleGraph, {own, Show("noise", z, " noise")}, action}};
}

bool HasGraph(const Bundle& bundle, const std::string& name) {
  return policy::FindGraph(bundle.graph, name).ok();
}

absl::Status Error(const std::string& where, absl::string_view expected,
                   absl::string_view found) {
  return absl::InvalidArgumentError(
      absl::StrCat(where, ": expected ", expected, ", found ", found));
}

absl::Status CheckPorts(const Bundle& bundle, const Wanted& wanted) {
  const std::string where = absl::StrCat(JoinPath(bundle.directory, kGraphFile),
                                         ": graph \"", wanted.graph, "\": ");
  SINEW_ASSIGN_OR_RETURN(const v1::Graph* graph,
                         policy::FindGraph(bundle.graph, wanted.graph));
  SINEW_ASSIGN_OR_RETURN((const std::map<std::string, int64_t> widths),
                         policy::InferWidths(bundle.graph, wanted.graph));
  std::set<std::string> inputs;
  for (const v1::GraphInput& input : graph->inputs()) {
    inputs.insert(ShowInput(input));
  }
  if (inputs != wanted.inputs) {
    return Error(where + "inputs", absl::StrJoin(wanted.inputs, ", "),
                 absl::StrJoin(inputs, ", "));
  }
  std::map<std::string, std::string> taps;
  for (const v1::Tap& tap : graph->taps()) {
    taps[tap.name()] = ShowTap(tap, widths.at(tap.value()));
  }
  for (const auto& [name, port] : wanted.taps) {
    const auto found = taps.find(name);
    if (found != taps.end() && found->second == port) continue;
    return Error(where + "taps", port,
                 found == taps.end() ? "none of that name" : found->second);
  }
  return absl::OkStatus();
}

absl::Status CheckPlacement(const Bundle& bundle) {
  const v1::Action::Placement found = bundle.manifest.action().placement();
  if (IsBlindPlacement(found)) return absl::OkStatus();
  return Error(
      JoinPath(bundle.directory, kManifestFile) + ": action.placement",
      "PLACEMENT_ABSOLUTE or PLACEMENT_AROUND_CURRENT, since a decoder "
      "sees no reference",
      v1::Action::Placement_Name(found));
}

}  // namespace

int64_t LatentWidth(const v1::PolicyGraph& graph) {
  const auto decoder = policy::FindGraph(graph, policy::kDecoderGraph);
  if (!decoder.ok()) return 0;
  for (const v1::GraphInput& input : (*decoder)->inputs()) {
    if (input.name() == "latent") return input.width();
  }
  return 0;
}

bool HasLatent(const Bundle& bundle) {
  return bundle.manifest.latent_width() != 0 ||
         bundle.manifest.self_observation_width() != 0 ||
         std::any_of(std::begin(kGraphs), std::end(kGraphs),
                     [&](const char* name) { return HasGraph(bundle, name); });
}

absl::Status CheckLatent(const Bundle& bundle) {
  if (!HasLatent(bundle)) return absl::OkStatus();
  for (const char* name : kGraphs) {
    if (HasGraph(bundle, name)) continue;
    return Error(
        JoinPath(bundle.directory, kGraphFile),
        absl::StrCat("a graph \"", name, "\", as bundles with a latent have"),
        "none of that name");
  }
  for (const Wanted& wanted : WantedGraphs(bundle)) {
    SINEW_RETURN_IF_ERROR(CheckPorts(bundle, wanted));
  }
  return CheckPlacement(bundle);
}

}  // namespace sinew::bundle
