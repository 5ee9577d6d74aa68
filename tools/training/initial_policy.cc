#include "tools/training/initial_policy.h"

#include <algorithm>
#include <cstdint>
#include <functional>
#include <memory>
#include <utility>

#include "absl/algorithm/container.h"
#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "absl/strings/string_view.h"
#include "common/logging.h"
#include "common/policy/builder.h"
#include "common/policy/validate.h"
#include "common/rpc/credentials.h"
#include "common/status_context.h"
#include "common/status_macros.h"
#include "deploy/bundle/bundle.h"
#include "deploy/bundle/run_export.h"
#include "deploy/checkpoint/client/artifact_store.h"
#include "deploy/checkpoint/open_store.h"
#include "learner/state/state_store.h"
#include "learner/trainer/trainer.h"
#include "tools/training/same_message.h"

namespace sinew::tools {
namespace {

std::string Quoted(absl::string_view text) {
  return absl::StrCat("\"", text, "\"");
}

absl::Status CheckCharacter(const v1::BundleManifest& manifest,
                            const TaskSetup& setup) {
  if (manifest.character() != setup.character) {
    return Unfit("character", Quoted(setup.character),
                 Quoted(manifest.character()));
  }
  std::vector<std::string> joints;
  for (const v1::BundleJoint& joint : manifest.joints()) {
    joints.push_back(joint.name());
  }
  if (joints != setup.joints) {
    return Unfit("joints", absl::StrJoin(setup.joints, ", "),
                 absl::StrJoin(joints, ", "));
  }
  return SameValue("character_sha256", setup.character_sha256,
                   manifest.character_sha256());
}

absl::Status CheckObservation(const bundle::Bundle& bundle,
                              const v1::Recipe& recipe,
                              const TaskSetup& setup) {
  SINEW_RETURN_IF_ERROR(
      SameMessage("observation", recipe.task().observation(),
                  bundle::TaskRecipe(bundle.manifest).task().observation()));
  return SameValue<int64_t>("observation_width", setup.observation_width,
                            bundle.manifest.observation_width());
}

// Whether the bundle's policy means the same by what it sees and does.
absl::Status CheckTask(const bundle::Bundle& bundle, const v1::Recipe& recipe,
                       const TaskSetup& setup) {
  SINEW_RETURN_IF_ERROR(CheckCharacter(bundle.manifest, setup));
  SINEW_RETURN_IF_ERROR(CheckObservation(bundle, recipe, setup));
  SINEW_RETURN_IF_ERROR(
      SameMessage("action", recipe.task().action(),
                  bundle::TaskRecipe(bundle.manifest).task().action()));
  return SameValue("control_hz", recipe.physics().control_hz(),
                   bundle.manifest.control_hz());
}

std::vector<int64_t> ShapeOf(const v1::PolicyGraph& graph,
                             const std::string& name) {
  for (const v1::Parameter& parameter : graph.parameters()) {
    if (parameter.name() != name) continue;
    return {parameter.shape().begin(), parameter.shape().end()};
  }
  return {};
}

// A layer may be narrower where a run begins; which ones, the learner knows
// (learner/update/widening.h).
bool FitsInto(const std::vector<int64_t>& narrow,
              const std::vector<int64_t>& wide) {
  return narrow.size() == wide.size() &&
         std::equal(narrow.begin(), narrow.end(), wide.begin(),
                    std::less_equal<>());
}

std::string Describe(const std::vector<int64_t>& shape) {
  if (shape.empty()) return "none";
  return absl::StrCat("[", absl::StrJoin(shape, ", "), "]");
}

// A graph's nodes but for the last two where those are exploration
// (common/policy/layers.h), which PPO's policies have and students have not.
std::vector<const v1::Node*> LearnedNodes(const v1::Graph& graph) {
  std::vector<const v1::Node*> nodes;
  for (const v1::Node& node : graph.nodes()) nodes.push_back(&node);
  if (nodes.size() < 2) return nodes;
  const v1::Node& noise = *nodes[nodes.size() - 2];
  const v1::Node& sum = *nodes.back();
  if (noise.op() == v1::OP_AFFINE &&
      absl::c_linear_search(noise.parameters(), "policy/std") &&
      sum.op() == v1::OP_ADD &&
      absl::c_linear_search(sum.inputs(), noise.name())) {
    nodes.resize(nodes.size() - 2);
  }
  return nodes;
}

// The last one's name is not compared: a latent's action is called "mean" where
// exploration follows it, and "action" where nothing does.
v1::Node Anonymous(const v1::Node& node, bool last) {
  v1::Node copy = node;
  if (last) copy.clear_name();
  return copy;
}

// Whether layers may be narrower than the run's, which widens them then.
enum class Widths { kSame, kAtMost };

// Whether graph `name` computes the same in both, weights, exploration and
// layers that are narrower in `found` apart; `field` of the recipe decides on
// it.
absl::Status SameGraph(const std::string& name, const std::string& field,
                       Widths widths, const v1::PolicyGraph& expected,
                       const v1::PolicyGraph& found) {
  SINEW_ASSIGN_OR_RETURN(const v1::Graph* want,
                         policy::FindGraph(expected, name));
  SINEW_ASSIGN_OR_RETURN(const v1::Graph* have, policy::FindGraph(found, name));
  const std::vector<const v1::Node*> want_nodes = LearnedNodes(*want);
  const std::vector<const v1::Node*> have_nodes = LearnedNodes(*have);
  if (want_nodes.size() != have_nodes.size()) {
    return Unfit(absl::StrCat("graph ", name, " (", field, ")"),
                 absl::StrCat(want_nodes.size(), " nodes"),
                 absl::StrCat(have_nodes.size()));
  }
  for (size_t i = 0; i < want_nodes.size(); ++i) {
    const v1::Node& node = *want_nodes[i];
    const bool last = i + 1 == want_nodes.size();
    SINEW_RETURN_IF_ERROR(
        SameMessage(absl::StrCat("graph ", name, ": node ", node.name()),
                    Anonymous(node, last), Anonymous(*have_nodes[i], last)));
    for (const std::string& parameter : node.parameters()) {
      const std::vector<int64_t> wide = ShapeOf(expected, parameter);
      const std::vector<int64_t> narrow = ShapeOf(found, parameter);
      const bool same = widths == Widths::kSame;
      if (same ? narrow == wide : FitsInto(narrow, wide)) continue;
      return Unfit(
          absl::StrCat("parameter ", parameter, " (", field, "): shape"),
          absl::StrCat(same ? "" : "at most ", Describe(wide)),
          Describe(narrow));
    }
  }
  return absl::OkStatus();
}

// The same of what is trained: the prior is not part of the policy.
absl::Status SameNetwork(Widths widths, const v1::PolicyGraph& expected,
                         const v1::PolicyGraph& found) {
  SINEW_RETURN_IF_ERROR(
      SameGraph("policy", "network.policy_hidden", widths, expected, found));
  if (!policy::FindGraph(expected, "prior").ok()) return absl::OkStatus();
  return SameGraph("prior", "network.latent.prior_hidden", widths, expected,
                   found);
}

bool IsComposer(const v1::PolicyGraph& graph) {
  return std::any_of(graph.parameters().begin(), graph.parameters().end(),
                     [](const v1::Parameter& parameter) {
                       return policy::IsComposerParameter(parameter.name());
                     });
}

absl::Status CheckPrimitive(const bundle::Bundle& bundle,
                            const v1::Recipe& recipe, const TaskSetup& setup) {
  if (IsComposer(bundle.graph)) {
    return Unfit("graph policy", "a policy of one network", "a composer");
  }
  SINEW_RETURN_IF_ERROR(CheckTask(bundle, recipe, setup));
  policy::TrackingPolicyOptions options;
  options.observation_width = setup.observation_width;
  options.action_width = setup.action_width;
  options.network = recipe.network();
  options.network.clear_composer();
  SINEW_ASSIGN_OR_RETURN(const v1::PolicyGraph alone,
                         policy::BuildTrackingPolicy(options));
  return SameNetwork(Widths::kSame, alone, bundle.graph);
}

absl::Status TakeInit(const InitialPolicy& policy, const v1::Recipe& recipe,
                      const TaskSetup& setup, learner::Learner& learner) {
  const std::string& directory = policy.init;
  SINEW_ASSIGN_OR_RETURN(const bundle::Bundle bundle,
                         bundle::ReadBundle(directory));
  SINEW_RETURN_IF_ERROR(
      WithContext(CheckTask(bundle, recipe, setup), directory));
  SINEW_RETURN_IF_ERROR(WithContext(
      SameNetwork(Widths::kAtMost, learner.graph(), bundle.graph), directory));
  TensorMap weights = bundle.weights;
  weights.insert(policy.critic.begin(), policy.critic.end());
  SINEW_RETURN_IF_ERROR(WithContext(learner.InitFrom(weights), directory));
  LogInfo("weights taken", {{"bundle", directory}});
  return absl::OkStatus();
}

absl::Status TakePrimitives(const std::vector<std::string>& directories,
                            const v1::Recipe& recipe, const TaskSetup& setup,
                            learner::PpoLearner& learner) {
  std::vector<learner::Primitive> primitives;
  for (const std::string& directory : directories) {
    SINEW_ASSIGN_OR_RETURN(bundle::Bundle bundle,
                           bundle::ReadBundle(directory));
    SINEW_RETURN_IF_ERROR(
        WithContext(CheckPrimitive(bundle, recipe, setup), directory));
    primitives.push_back({directory, std::move(bundle.weights)});
  }
  SINEW_RETURN_IF_ERROR(learner.InitFromPrimitives(primitives));
  LogInfo("primitives taken", {{"bundles", absl::StrJoin(directories, " ")}});
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<TensorMap> ReadCritic(const std::string& checkpoints,
                                     int64_t iteration, const Clock& clock) {
  SINEW_ASSIGN_OR_RETURN(
      const std::unique_ptr<checkpoint::ArtifactStore> store,
      checkpoint::OpenStore(checkpoints, checkpoint::StoreAccess::kRead,
                            rpc::Security(), clock));
  std::vector<std::string> warnings;
  SINEW_ASSIGN_OR_RETURN(learner::Trainer::State state,
                         learner::LoadLatestState(*store, &warnings));
  for (const std::string& warning : warnings) LogWarning(warning);
  if (state.counters.iteration() != iteration) {
    return absl::DataLossError(absl::StrCat(
        checkpoints, ": expected a whole state of iteration ", iteration,
        ", which the bundle beside it is of, found one of iteration ",
        state.counters.iteration()));
  }
  std::erase_if(state.tensors, [](const auto& tensor) {
    return !absl::StartsWith(tensor.first, "critic/");
  });
  if (state.tensors.empty()) {
    return absl::DataLossError(
        absl::StrCat(checkpoints, ": training state of iteration ",
                     state.counters.iteration(),
                     ": expected tensors critic/..., found none"));
  }
  return std::move(state.tensors);
}

absl::Status BeginWith(const InitialPolicy& policy, const v1::Recipe& recipe,
                       const TaskSetup& setup, learner::PpoLearner& learner) {
  const int count = static_cast<int>(policy.primitives.size());
  if (!policy.init.empty() && count > 0) {
    return absl::InvalidArgumentError(
        "--init and --primitives: expected one of them, found both");
  }
  if (!policy.init.empty()) {
    return TakeInit(policy, recipe, setup, learner);
  }
  const v1::Network& network = recipe.network();
  const int expected =
      network.has_composer() ? network.composer().primitives() : 0;
  if (count != expected) {
    return absl::InvalidArgumentError(absl::StrCat(
        "recipe field network.composer: expected the bundles of ", expected,
        " primitives (--primitives)",
        expected > 0 ? " or of a composer (--init)" : "", ", found ", count));
  }
  if (count == 0) return absl::OkStatus();
  return TakePrimitives(policy.primitives, recipe, setup, learner);
}

absl::Status BeginWithInit(const InitialPolicy& policy,
                           const v1::Recipe& recipe, const TaskSetup& setup,
                           learner::Learner& learner) {
  if (!policy.primitives.empty()) {
    return absl::InvalidArgumentError(
        "--primitives: expected a recipe with network.composer, found one with "
        "distillation");
  }
  if (policy.init.empty()) return absl::OkStatus();
  return TakeInit(policy, recipe, setup, learner);
}

absl::StatusOr<std::vector<v1::RunInputs::Source>> InitialSources(
    const InitialPolicy& policy) {
  std::vector<v1::RunInputs::Source> sources;
  const auto add = [&](const char* role, const std::string& directory) {
    const absl::StatusOr<bundle::Bundle> read = bundle::ReadBundle(directory);
    if (read.ok()) sources.push_back(bundle::MakeSource(role, read->manifest));
    return read.status();
  };
  if (!policy.init.empty()) {
    SINEW_RETURN_IF_ERROR(add("init", policy.init));
  }
  for (const std::string& primitive : policy.primitives) {
    SINEW_RETURN_IF_ERROR(add("primitive", primitive));
  }
  return sources;
}

}  // namespace sinew::tools
