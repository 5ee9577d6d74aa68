#include "tools/sampling/testing/latent_bundle.h"

#include <cstdint>
#include <utility>
#include <vector>

#include "common/check.h"
#include "common/files.h"
#include "common/policy/safetensors.h"
#include "common/random/philox.h"
#include "deploy/bundle/testing/toy_bundle.h"
#include "proto/sinew/v1/graph.pb.h"

namespace sinew::sampling::testing {
namespace {

// Adds one graph to a bundle's content.
class Writer {
 public:
  Writer(bundle::BundleContent& content, const std::string& name)
      : content_(content), graph_(*content.graph.add_graphs()) {
    graph_.set_name(name);
  }

  void Input(const std::string& name, int64_t width,
             v1::GraphInput::Kind kind = v1::GraphInput::KIND_DATA) {
    v1::GraphInput* input = graph_.add_inputs();
    input->set_name(name);
    input->set_width(width);
    input->set_kind(kind);
  }

  v1::Node& Node(const std::string& name, v1::Op op,
                 const std::vector<std::string>& inputs) {
    v1::Node* node = graph_.add_nodes();
    node->set_name(name);
    node->set_op(op);
    for (const std::string& input : inputs) node->add_inputs(input);
    return *node;
  }

  // A layer with parameters PREFIX/weight, PREFIX/bias, which graphs share.
  void Linear(const std::string& name, const std::string& input,
              const std::string& prefix, int64_t out, int64_t in, float scale) {
    v1::Node& node = Node(name, v1::OP_LINEAR, {input});
    node.add_parameters(prefix + "/weight");
    node.add_parameters(prefix + "/bias");
    Parameter(prefix + "/weight", {out, in}, scale);
    Parameter(prefix + "/bias", {out}, scale);
  }

  // NAME_mean, NAME_log_variance, NAME_std of `input`, with taps if `shown`.
  void Gaussian(const std::string& name, const std::string& prefix,
                const std::string& input, int64_t in, bool shown) {
    Linear(name + "_mean", input, prefix + "/mean", kToyLatent, in, 0.1F);
    Linear(name + "_log_variance", input, prefix + "/log_variance", kToyLatent,
           in, 0);
    Node(name + "_std", v1::OP_EXP, {name + "_log_variance"});
    if (!shown) return;
    Tap("mean", name + "_mean");
    Tap("std", name + "_std");
    Tap("log_variance", name + "_log_variance");
  }

  // "action" of self_observation and latent.
  void Decoder(int64_t joints) {
    Node("joined", v1::OP_CONCAT, {"self_observation", "latent"});
    Linear("action", "joined", "decoder/action", joints, kToySelf + kToyLatent,
           0.3F);
    Tap("action", "action").set_executed(true);
  }

  v1::Tap& Tap(const std::string& name, const std::string& value) {
    v1::Tap* tap = graph_.add_taps();
    tap->set_name(name);
    tap->set_value(value);
    return *tap;
  }

 private:
  // Normal times `scale`; one that is there already is left alone.
  void Parameter(const std::string& name, const std::vector<int64_t>& shape,
                 float scale) {
    if (content_.weights.contains(name)) return;
    v1::Parameter* parameter = content_.graph.add_parameters();
    parameter->set_name(name);
    parameter->mutable_shape()->Add(shape.begin(), shape.end());
    HostTensor tensor = HostTensor::Zeros(shape);
    FillNormal({.seed = content_.weights.size()}, tensor.mutable_float32());
    for (float& value : tensor.mutable_float32()) value *= scale;
    content_.weights[name] = std::move(tensor);
  }

  bundle::BundleContent& content_;
  v1::Graph& graph_;
};

}  // namespace

world::testing::ToyWorld MakeLatentToy() {
  v1::Recipe recipe = world::testing::ToyRecipe();
  recipe.mutable_task()->mutable_action()->set_placement(
      v1::Action::PLACEMENT_ABSOLUTE);
  return world::testing::MakeToyWorld(recipe);
}

bundle::BundleContent LatentContent(const world::testing::ToyWorld& toy) {
  bundle::BundleContent content = bundle::testing::ToyContent(toy);
  const int64_t joints = content.manifest.action_width();
  const int64_t observations = content.manifest.observation_width();
  Writer encoder(content, "encoder");
  encoder.Input("observation", observations);
  encoder.Gaussian("posterior", "encoder", "observation", observations,
                   /*shown=*/true);
  Writer prior(content, "prior");
  prior.Input("self_observation", kToySelf);
  prior.Gaussian("prior", "prior", "self_observation", kToySelf,
                 /*shown=*/true);
  Writer decoder(content, "decoder");
  decoder.Input("self_observation", kToySelf);
  decoder.Input("latent", kToyLatent);
  decoder.Decoder(joints);
  Writer sample(content, "sample");
  sample.Input("self_observation", kToySelf);
  sample.Input("noise", kToyLatent, v1::GraphInput::KIND_NORMAL);
  sample.Gaussian("prior", "prior", "self_observation", kToySelf,
                  /*shown=*/false);
  sample.Node("scaled", v1::OP_MULTIPLY, {"prior_std", "noise"});
  sample.Node("latent", v1::OP_ADD, {"prior_mean", "scaled"});
  sample.Decoder(joints);
  sample.Tap("latent", "latent");
  content.manifest.set_self_observation_width(kToySelf);
  content.manifest.set_latent_width(kToyLatent);
  return content;
}

std::string WriteLatentBundle(const world::testing::ToyWorld& toy) {
  const std::string directory = JoinPath(toy.folder, "bundle");
  const absl::Status written =
      bundle::WriteBundle(LatentContent(toy), directory);
  SINEW_CHECK(written.ok()) << written.ToString();
  return directory;
}

}  // namespace sinew::sampling::testing
