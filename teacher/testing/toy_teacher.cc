#include "teacher/testing/toy_teacher.h"

#include <initializer_list>
#include <limits>
#include <string>
#include <utility>

#include "common/config/recipe.h"
#include "common/policy/builder.h"
#include "common/random/philox.h"

namespace sinew::teacher::testing {
namespace {

constexpr int64_t kObservations = 21;
constexpr int64_t kActions = 3;
constexpr int64_t kLatent = 2;

v1::BundleManifest MakeManifest() {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  v1::BundleManifest manifest;
  manifest.set_manifest_sha256(std::string(64, 'a'));
  manifest.set_character_sha256(std::string(64, 'b'));
  manifest.set_observation_width(kObservations);
  manifest.set_action_width(kActions);
  manifest.mutable_action()->set_strength_scale(0.25);
  for (const char* name : {"a", "b", "c"}) {
    v1::BundleJoint* joint = manifest.add_joints();
    joint->set_name(name);
    joint->set_stiffness(100);
    joint->set_damping(10);
    joint->set_torque_limit(80);
    joint->set_lower(-1);
    joint->set_upper(1);
  }
  manifest.mutable_joints(1)->set_lower(-kInfinity);
  manifest.mutable_joints(1)->set_upper(kInfinity);
  manifest.mutable_joints(2)->set_torque_limit(40);
  return manifest;
}

void AddNode(v1::Graph& graph, const std::string& name, v1::Op op,
             std::initializer_list<const char*> inputs) {
  v1::Node* node = graph.add_nodes();
  node->set_name(name);
  node->set_op(op);
  for (const char* input : inputs) node->add_inputs(input);
}

void AddInput(v1::Graph& graph, const std::string& name, int64_t width,
              v1::GraphInput::Kind kind) {
  v1::GraphInput* input = graph.add_inputs();
  input->set_name(name);
  input->set_width(width);
  input->set_kind(kind);
}

// A linear layer's parameters: of the last node of the graph.
void AddLayer(TeacherPolicy& policy, int64_t out, int64_t in) {
  v1::Graph& graph = *policy.graph.mutable_graphs(0);
  v1::Node& node = *graph.mutable_nodes(graph.nodes_size() - 1);
  const std::vector<std::pair<std::string, std::vector<int64_t>>> shapes = {
      {node.name() + "/weight", {out, in}}, {node.name() + "/bias", {out}}};
  for (const auto& [name, shape] : shapes) {
    v1::Parameter* parameter = policy.graph.add_parameters();
    parameter->set_name(name);
    parameter->mutable_shape()->Add(shape.begin(), shape.end());
    node.add_parameters(name);
    HostTensor tensor = HostTensor::Zeros(shape);
    FillNormal({.seed = policy.weights.size() + 1}, tensor.mutable_float32());
    policy.weights[name] = std::move(tensor);
  }
}

}  // namespace

TeacherPolicy MakeToyTeacher(uint64_t seed) {
  policy::TrackingPolicyOptions options;
  options.observation_width = kObservations;
  options.action_width = kActions;
  options.network = WithDefaults(v1::Recipe()).network();
  options.network.clear_policy_hidden();
  options.network.add_policy_hidden(24);
  options.network.set_last_layer_gain(2);
  TeacherPolicy result;
  result.graph = policy::BuildTrackingPolicy(options).value();
  result.weights = policy::InitialWeights(options, seed).value();
  result.manifest = MakeManifest();
  result.joint_action_scales = {0, 0.5, 0};
  return result;
}

TeacherPolicy MakeToyStudent() {
  TeacherPolicy result;
  result.manifest = MakeManifest();
  result.joint_action_scales = {0, 0.5, 0};
  result.graph.set_format_version(1);
  v1::Graph& graph = *result.graph.add_graphs();
  graph.set_name("policy");
  AddInput(graph, "observation", kObservations, v1::GraphInput::KIND_DATA);
  AddInput(graph, "noise", kLatent, v1::GraphInput::KIND_NORMAL);
  AddNode(graph, "posterior_mean", v1::OP_LINEAR, {"observation"});
  AddLayer(result, kLatent, kObservations);
  AddNode(graph, "latent", v1::OP_ADD, {"posterior_mean", "noise"});
  AddNode(graph, "action", v1::OP_LINEAR, {"latent"});
  AddLayer(result, kActions, kLatent);
  v1::Tap* tap = graph.add_taps();
  tap->set_name("action");
  tap->set_value("action");
  tap->set_executed(true);
  return result;
}

ToyRows MakeToyRows(int64_t rows, uint64_t seed) {
  ToyRows result;
  result.observations.resize(rows * kObservations);
  std::vector<float> bases(rows * kActions);
  FillNormal({.seed = seed}, absl::MakeSpan(result.observations));
  FillNormal({.seed = seed, .step = 1}, absl::MakeSpan(bases));
  result.bases.assign(bases.begin(), bases.end());
  return result;
}

}  // namespace sinew::teacher::testing
