#include "deploy/bundle/bundle_check.h"

#include <mujoco/mujoco.h>

#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_join.h"
#include "common/config/message_differences.h"
#include "common/config/recipe.h"
#include "common/digest.h"
#include "common/files.h"
#include "common/policy/ports.h"
#include "common/policy/validate.h"
#include "common/status_context.h"
#include "common/status_macros.h"
#include "deploy/bundle/latent_graphs.h"
#include "deploy/bundle/manifest.h"
#include "sim/world/observation.h"

namespace sinew::bundle {
namespace {

using google::protobuf::Message;

// Compares manifest fields and keeps the first difference.
class ManifestChecker {
 public:
  explicit ManifestChecker(const Bundle& bundle)
      : file_(JoinPath(bundle.directory, kManifestFile)) {}

  template <typename T>
  void Equal(absl::string_view field, const T& expected, const T& found) {
    if (!status_.ok() || expected == found) return;
    status_ = absl::InvalidArgumentError(
        absl::StrCat(file_, ": ", field, ": expected ", Show(expected),
                     ", found ", Show(found)));
  }
  void SameAsInTask(absl::string_view field, const Message& expected,
                    const Message& found) {
    if (!status_.ok() || SerializeDeterministically(expected) ==
                             SerializeDeterministically(found)) {
      return;
    }
    status_ = absl::InvalidArgumentError(
        absl::StrCat(file_, ": ", field, ": expected what task says, found ",
                     MessageDifferences(expected, found)));
  }
  const absl::Status& status() const { return status_; }

 private:
  static std::string Show(const std::string& value) {
    return absl::StrCat("\"", value, "\"");
  }
  static std::string Show(double value) {
    return absl::StrFormat("%.9g", value);
  }
  static std::string Show(int64_t value) { return absl::StrCat(value); }
  static std::string Show(int value) { return absl::StrCat(value); }

  const std::string file_;
  absl::Status status_;
};

void CheckJoint(const std::string& field, const character::JointInfo& expected,
                const v1::BundleJoint& found, ManifestChecker& check) {
  const std::string suffix = absl::StrCat(" (", expected.name, ")");
  const auto compare = [&](const char* name, double want, double have) {
    check.Equal(absl::StrCat(field, ".", name, suffix), want, have);
  };
  check.Equal(absl::StrCat(field, ".name"), expected.name, found.name());
  compare("stiffness", expected.stiffness, found.stiffness());
  compare("damping", expected.damping, found.damping());
  compare("torque_limit", expected.torque_limit, found.torque_limit());
  compare("lower", expected.lower, found.lower());
  compare("upper", expected.upper, found.upper());
  compare("default_position", expected.default_position,
          found.default_position());
  if (found.has_action_scale()) {
    compare("action_scale", expected.action_scale, found.action_scale());
  }
}

std::vector<std::string> TrackedBodies(const character::Character& character) {
  std::vector<std::string> names;
  for (int column : character.tracked()) {
    const char* name = mj_id2name(character.model(), mjOBJ_BODY, column + 1);
    names.push_back(name == nullptr ? "" : name);
  }
  return names;
}

absl::Status CheckCharacter(const Bundle& bundle) {
  const character::Character& character = *bundle.character;
  const v1::BundleManifest& manifest = bundle.manifest;
  const auto joints = static_cast<int>(character.joints().size());
  ManifestChecker check(bundle);
  check.Equal("character", character.name(), manifest.character());
  check.Equal("joints: their number", joints, manifest.joints_size());
  for (int j = 0; j < joints && check.status().ok(); ++j) {
    CheckJoint(absl::StrCat("joints[", j, "]"), character.joints()[j],
               manifest.joints(j), check);
  }
  check.Equal("bodies", absl::StrJoin(TrackedBodies(character), ", "),
              absl::StrJoin(manifest.bodies(), ", "));
  check.Equal("character_sha256", character.digest(),
              manifest.character_sha256());
  return check.status();
}

absl::Status CheckTask(const Bundle& bundle) {
  const v1::BundleManifest& manifest = bundle.manifest;
  const std::string file = JoinPath(bundle.directory, kManifestFile);
  const v1::Recipe recipe = TaskRecipe(manifest);
  SINEW_RETURN_IF_ERROR(WithContext(ValidateRecipe(recipe), file));
  ManifestChecker check(bundle);
  check.Equal("control_hz", recipe.physics().control_hz(),
              manifest.control_hz());
  check.Equal("physics_hz", recipe.physics().physics_hz(),
              manifest.physics_hz());
  check.SameAsInTask("observation", manifest.task().observation(),
                     manifest.observation());
  check.SameAsInTask("action", manifest.task().action(), manifest.action());
  return check.status();
}

absl::Status CheckWidths(const Bundle& bundle) {
  const v1::BundleManifest& manifest = bundle.manifest;
  const character::Character& character = *bundle.character;
  const auto observation = world::ObservationBuilder::Create(
      manifest.observation(), static_cast<int>(character.tracked().size()),
      static_cast<int>(character.joints().size()),
      static_cast<int>(character.foot_bodies().size()));
  SINEW_RETURN_IF_ERROR(WithContext(observation.status(),
                                    JoinPath(bundle.directory, kManifestFile)));
  ManifestChecker check(bundle);
  check.Equal<int64_t>("observation_width", observation->width(),
                       manifest.observation_width());
  check.Equal<int64_t>("action_width",
                       static_cast<int64_t>(character.joints().size()),
                       manifest.action_width());
  if (HasLatent(bundle)) {
    check.Equal<int64_t>("self_observation_width", observation->self_width(),
                         manifest.self_observation_width());
  }
  return check.status();
}

// What is executed is decided anew every control step, by whoever acts.
absl::Status CheckDecisions(const v1::PolicyGraph& all) {
  for (const v1::Graph& graph : all.graphs()) {
    for (const v1::Tap& tap : graph.taps()) {
      if (!tap.executed()) continue;
      if (tap.decision_period() > 1) {
        return absl::InvalidArgumentError(absl::StrCat(
            "graph ", graph.name(), ": tap ", tap.name(),
            ": decision_period: expected 0 or 1, a decision every step, found ",
            tap.decision_period()));
      }
      if (tap.has_categorical()) {
        return absl::InvalidArgumentError(absl::StrCat(
            "graph ", graph.name(), ": tap ", tap.name(),
            ": expected a Gaussian or no distribution, found categorical"));
      }
    }
  }
  return absl::OkStatus();
}

absl::Status CheckGraph(const Bundle& bundle) {
  const std::string weights = JoinPath(bundle.directory, kWeightsFile);
  const std::string file = JoinPath(bundle.directory, kGraphFile);
  SINEW_RETURN_IF_ERROR(WithContext(policy::ValidateGraph(bundle.graph), file));
  SINEW_RETURN_IF_ERROR(CheckFinite(bundle.weights, weights));
  SINEW_RETURN_IF_ERROR(WithContext(
      policy::ValidateGraph(bundle.graph, bundle.weights), weights));
  const auto ports = policy::FindPorts(bundle.graph, "policy");
  if (absl::IsNotFound(ports.status())) {
    return absl::InvalidArgumentError(
        absl::StrCat(file, ": ", ports.status().message()));
  }
  SINEW_RETURN_IF_ERROR(WithContext(ports.status(), file));
  SINEW_RETURN_IF_ERROR(WithContext(CheckDecisions(bundle.graph), file));
  SINEW_RETURN_IF_ERROR(CheckLatent(bundle));
  std::vector<std::string> names;
  for (const v1::Graph& graph : bundle.graph.graphs()) {
    names.push_back(graph.name());
  }
  ManifestChecker check(bundle);
  check.Equal("graphs", absl::StrJoin(names, ", "),
              absl::StrJoin(bundle.manifest.graphs(), ", "));
  check.Equal("observation_width", ports->observation_width,
              bundle.manifest.observation_width());
  check.Equal("action_width", ports->action_width,
              bundle.manifest.action_width());
  check.Equal("latent_width", LatentWidth(bundle.graph),
              bundle.manifest.latent_width());
  return check.status();
}

absl::Status CheckProvenance(const Bundle& bundle) {
  const v1::BundleProvenance& provenance = bundle.manifest.provenance();
  if (provenance.clip_uses().empty()) return absl::OkStatus();
  ManifestChecker check(bundle);
  check.Equal("provenance.clip_uses: their number", provenance.clips_size(),
              provenance.clip_uses_size());
  return check.status();
}

}  // namespace

absl::Status CheckBundle(const Bundle& bundle) {
  SINEW_RETURN_IF_ERROR(CheckTask(bundle));
  SINEW_RETURN_IF_ERROR(CheckCharacter(bundle));
  SINEW_RETURN_IF_ERROR(CheckWidths(bundle));
  SINEW_RETURN_IF_ERROR(CheckProvenance(bundle));
  return CheckGraph(bundle);
}

}  // namespace sinew::bundle
