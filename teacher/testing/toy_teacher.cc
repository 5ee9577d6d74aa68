#include "teacher/testing/toy_teacher.h"

#include <limits>
#include <string>
#include <utility>

#include "common/config/recipe.h"
#include "common/policy/builder.h"
#include "common/policy/latent_builder.h"
#include "common/policy/safetensors.h"
#include "common/random/philox.h"

namespace sinew::teacher::testing {
namespace {

constexpr int64_t kObservations = 21;
constexpr int64_t kSelfObservations = 9;
constexpr int64_t kActions = 3;

v1::BundleManifest MakeManifest() {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  v1::BundleManifest manifest;
  manifest.set_manifest_sha256(std::string(64, 'a'));
  manifest.set_character_sha256(std::string(64, 'b'));
  manifest.set_control_hz(30);
  manifest.mutable_provenance()->set_recipe("toy");
  manifest.mutable_provenance()->add_clips("turn: made for tests (Apache-2.0)");
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

// The default network with narrow layers, and lively.
v1::Network MakeNetwork() {
  v1::Recipe recipe;
  v1::Network& network = *recipe.mutable_network();
  network.add_policy_hidden(24);
  network.set_last_layer_gain(2);
  v1::Latent& latent = *network.mutable_latent();
  latent.set_width(2);
  latent.add_encoder_hidden(24);
  latent.add_prior_hidden(24);
  latent.add_decoder_hidden(24);
  return WithDefaults(std::move(recipe)).network();
}

TeacherPolicy MakeTeacher(v1::PolicyGraph graph, TensorMap weights) {
  return {.graph = std::move(graph),
          .weights = std::move(weights),
          .manifest = MakeManifest(),
          .joint_action_scales = {0, 0.5, 0}};
}

}  // namespace

TeacherPolicy MakeToyTeacher(uint64_t seed) {
  const policy::TrackingPolicyOptions options = {
      .observation_width = kObservations,
      .action_width = kActions,
      .network = MakeNetwork()};
  return MakeTeacher(policy::BuildTrackingPolicy(options).value(),
                     policy::InitialWeights(options, seed).value());
}

TeacherPolicy MakeToyStudent() {
  const policy::LatentPolicyOptions options = {
      .self_observation_width = kSelfObservations,
      .observation_width = kObservations,
      .action_width = kActions,
      .network = MakeNetwork()};
  return MakeTeacher(policy::BuildLatentPolicy(options).value(),
                     policy::InitialLatentWeights(options, /*seed=*/1).value());
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
