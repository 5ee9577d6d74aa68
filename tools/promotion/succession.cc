#include "tools/promotion/succession.h"

#include <algorithm>
#include <cstdint>
#include <string>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "absl/strings/string_view.h"
#include "common/config/message_differences.h"
#include "common/status_macros.h"
#include "deploy/bundle/bundle.h"
#include "google/protobuf/message.h"
#include "proto/sinew/v1/recipe.pb.h"

namespace sinew::tools {
namespace {

absl::Status CheckWidth(absl::string_view field, int64_t incumbent,
                        int64_t candidate) {
  if (incumbent == 0 || incumbent == candidate) return absl::OkStatus();
  return absl::FailedPreconditionError(absl::StrCat(
      field, ": expected the incumbent's ", incumbent, ", found ", candidate));
}

absl::Status CheckGraphs(const v1::BundleManifest& incumbent,
                         const v1::BundleManifest& candidate) {
  const auto& graphs = candidate.graphs();
  for (const std::string& name : incumbent.graphs()) {
    if (std::find(graphs.begin(), graphs.end(), name) != graphs.end()) continue;
    return absl::FailedPreconditionError(absl::StrCat(
        "graphs: expected \"", name, "\", which the incumbent has, found ",
        graphs.empty() ? "none" : absl::StrJoin(graphs, ", ")));
  }
  return absl::OkStatus();
}

absl::Status CheckEqual(absl::string_view field,
                        const google::protobuf::Message& incumbent,
                        const google::protobuf::Message& candidate) {
  const std::string differences = MessageDifferences(incumbent, candidate);
  if (differences.empty()) return absl::OkStatus();
  return absl::FailedPreconditionError(
      absl::StrCat(field, ": expected the incumbent's, found ", differences));
}

// That evaluations have.
v1::Randomisation Evaluated(const v1::Recipe& recipe) {
  const v1::Randomisation& randomisation = recipe.task().randomisation();
  return randomisation.in_evaluation() ? randomisation : v1::Randomisation();
}

}  // namespace

absl::Status CheckSuccession(const v1::BundleManifest& incumbent,
                             const v1::BundleManifest& candidate) {
  SINEW_RETURN_IF_ERROR(CheckGraphs(incumbent, candidate));
  SINEW_RETURN_IF_ERROR(CheckWidth("latent_width", incumbent.latent_width(),
                                   candidate.latent_width()));
  SINEW_RETURN_IF_ERROR(CheckWidth("self_observation_width",
                                   incumbent.self_observation_width(),
                                   candidate.self_observation_width()));
  const v1::Recipe before = bundle::TaskRecipe(incumbent);
  const v1::Recipe after = bundle::TaskRecipe(candidate);
  SINEW_RETURN_IF_ERROR(
      CheckEqual("physics", before.physics(), after.physics()));
  SINEW_RETURN_IF_ERROR(CheckEqual("task.actuator_model",
                                   before.task().actuator_model(),
                                   after.task().actuator_model()));
  return CheckEqual("task.randomisation", Evaluated(before), Evaluated(after));
}

}  // namespace sinew::tools
