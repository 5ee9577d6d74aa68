#include "deploy/bundle/testing/toy_latent.h"

#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/match.h"
#include "common/digest.h"
#include "common/random/philox.h"
#include "deploy/bundle/content.h"
#include "deploy/bundle/testing/toy_bundle.h"

namespace sinew::bundle::testing {
namespace {

constexpr int64_t kHidden = 12;
constexpr double kClip = 5;

using Names = std::vector<std::string>;

// Writes the graphs one after another; see latent_builder.h.
class LatentWriter {
 public:
  explicit LatentWriter(const LatentWidths& widths) : w_(widths) {
    all_.set_format_version(1);
  }

  v1::PolicyGraph Write() {
    Begin("policy");
    Observation();
    Encoder();
    Latent("posterior");
    Decoder("latent");
    Tap("mean", "action").set_recorded(true);
    all_.mutable_graphs(0)->mutable_taps(0)->set_recorded(true);
    Tap("latent", "latent");
    Begin("encoder");
    Observation();
    Encoder();
    GaussianTaps("posterior");
    Begin("prior");
    Own();
    Prior();
    GaussianTaps("prior");
    Begin("decoder");
    Own();
    Input("latent", w_.latent, v1::GraphInput::KIND_DATA);
    Decoder("latent");
    Begin("sample");
    Own();
    Prior();
    Latent("prior");
    Decoder("latent");
    Tap("latent", "latent");
    return std::move(all_);
  }

 private:
  v1::Graph& graph() { return *all_.mutable_graphs(all_.graphs_size() - 1); }
  void Begin(const std::string& name) { all_.add_graphs()->set_name(name); }

  void Input(const std::string& name, int64_t width,
             v1::GraphInput::Kind kind) {
    v1::GraphInput& input = *graph().add_inputs();
    input.set_name(name);
    input.set_width(width);
    input.set_kind(kind);
  }

  v1::Node& Node(const std::string& name, v1::Op op, const Names& inputs,
                 const Names& parameters = {}) {
    v1::Node& node = *graph().add_nodes();
    node.set_name(name);
    node.set_op(op);
    node.mutable_inputs()->Add(inputs.begin(), inputs.end());
    node.mutable_parameters()->Add(parameters.begin(), parameters.end());
    return node;
  }

  v1::Tap& Tap(const std::string& name, const std::string& value) {
    v1::Tap& tap = *graph().add_taps();
    tap.set_name(name);
    tap.set_value(value);
    return tap;
  }

  void Parameter(const std::string& name, const std::vector<int64_t>& shape,
                 bool frozen) {
    for (const v1::Parameter& known : all_.parameters()) {
      if (known.name() == name) return;
    }
    v1::Parameter& parameter = *all_.add_parameters();
    parameter.set_name(name);
    parameter.mutable_shape()->Add(shape.begin(), shape.end());
    parameter.set_frozen(frozen);
  }

  void Linear(const std::string& name, const std::string& input,
              const std::string& prefix, int64_t out, int64_t in) {
    Parameter(prefix + "/weight", {out, in}, /*frozen=*/false);
    Parameter(prefix + "/bias", {out}, /*frozen=*/false);
    Node(name, v1::OP_LINEAR, {input}, {prefix + "/weight", prefix + "/bias"});
  }

  void Clamp(const std::string& name, const std::string& input, double low,
             double high) {
    v1::Node& node = Node(name, v1::OP_CLAMP, {input});
    node.set_low(low);
    node.set_high(high);
  }

  // `what` ("own", "goal") normalised and clipped.
  void Normalised(const std::string& what, const std::string& input,
                  int64_t width) {
    const std::string prefix = "normaliser/" + what;
    Parameter(prefix + "/mean", {width}, /*frozen=*/true);
    Parameter(prefix + "/inverse_std", {width}, /*frozen=*/true);
    Node(what + "_normalised", v1::OP_NORMALISE, {input},
         {prefix + "/mean", prefix + "/inverse_std"});
    Clamp(what + "_clipped", what + "_normalised", -kClip, kClip);
  }

  void Slice(const std::string& name, int64_t begin, int64_t end) {
    v1::Node& node = Node(name, v1::OP_SLICE, {"observation"});
    node.set_begin(begin);
    node.set_end(end);
  }

  void Observation() {
    Input("observation", w_.observation, v1::GraphInput::KIND_DATA);
    Slice("own", 0, w_.self);
    Slice("goal", w_.self, w_.observation);
    Normalised("own", "own", w_.self);
    Normalised("goal", "goal", w_.observation - w_.self);
  }

  void Own() {
    Input("self_observation", w_.self, v1::GraphInput::KIND_DATA);
    Normalised("own", "self_observation", w_.self);
  }

  void Hidden(const std::string& network, const std::string& input,
              int64_t width) {
    const std::string name = network + "_hidden_0";
    Linear(name, input, network + "/linear_0", kHidden, width);
    Node(name + "_activation", v1::OP_SILU, {name});
  }

  // Mean and standard deviation from the last layer of `network`.
  void Gaussian(const std::string& network, const std::string& name) {
    const std::string last = network + "_hidden_0_activation";
    Linear(name + "_mean", last, network + "/mean", w_.latent, kHidden);
    Linear(name + "_free_log_variance", last, network + "/log_variance",
           w_.latent, kHidden);
    Clamp(name + "_log_variance", name + "_free_log_variance", -5, 2);
    Parameter("latent/half", {w_.latent}, /*frozen=*/true);
    Node(name + "_log_std", v1::OP_AFFINE, {name + "_log_variance"},
         {"latent/half"});
    Node(name + "_std", v1::OP_EXP, {name + "_log_std"});
  }

  void Encoder() {
    Node("encoder_input", v1::OP_CONCAT, {"own_clipped", "goal_clipped"});
    Hidden("encoder", "encoder_input", w_.observation);
    Gaussian("encoder", "posterior");
  }

  void Prior() {
    Hidden("prior", "own_clipped", w_.self);
    Gaussian("prior", "prior");
  }

  // z = mean + std * noise of "posterior" or "prior".
  void Latent(const std::string& of) {
    Input("noise", w_.latent, v1::GraphInput::KIND_NORMAL);
    Node("exploration", v1::OP_MULTIPLY, {of + "_std", "noise"});
    Node("latent", v1::OP_ADD, {of + "_mean", "exploration"});
  }

  void Decoder(const std::string& latent) {
    Node("decoder_input", v1::OP_CONCAT, {"own_clipped", latent});
    Hidden("decoder", "decoder_input", w_.self + w_.latent);
    Linear("action", "decoder_hidden_0_activation", "decoder/action", w_.action,
           kHidden);
    Tap("action", "action").set_executed(true);
  }

  void GaussianTaps(const std::string& of) {
    for (const char* name : {"mean", "std", "log_variance"}) {
      Tap(name, of + "_" + name);
    }
  }

  const LatentWidths w_;
  v1::PolicyGraph all_;
};

}  // namespace

v1::PolicyGraph LatentGraphs(const LatentWidths& widths) {
  return LatentWriter(widths).Write();
}

TensorMap LatentWeights(const v1::PolicyGraph& graph) {
  TensorMap weights;
  uint64_t number = 0;
  for (const v1::Parameter& parameter : graph.parameters()) {
    const std::vector<int64_t> shape(parameter.shape().begin(),
                                     parameter.shape().end());
    HostTensor tensor = HostTensor::Zeros(shape);
    const absl::Span<float> values = tensor.mutable_float32();
    FillNormal({.seed = 7,
                .environment = number++,
                .purpose = RandomPurpose::kInitialisation},
               values);
    const auto fan_in = static_cast<float>(shape.size() > 1 ? shape[1] : 25);
    for (float& value : values) {
      value /= std::sqrt(fan_in);
      if (absl::EndsWith(parameter.name(), "/inverse_std")) value += 1;
      if (parameter.name() == "latent/half") value = 0.5F;
    }
    weights[parameter.name()] = std::move(tensor);
  }
  return weights;
}

v1::Snapshot LatentSnapshot(const LatentWidths& widths) {
  v1::Snapshot snapshot;
  *snapshot.mutable_graph() = LatentGraphs(widths);
  snapshot.set_weights(SerializeSafetensors(LatentWeights(snapshot.graph())));
  return snapshot;
}

v1::Recipe ToyLatentRecipe() {
  v1::Recipe recipe = world::testing::ToyRecipe();
  recipe.mutable_task()->mutable_action()->set_placement(
      v1::Action::PLACEMENT_AROUND_CURRENT);
  return recipe;
}

BundleContent ToyLatentContent(const world::testing::ToyWorld& toy) {
  ContentInputs inputs = ToyInputs(toy);
  const std::string snapshot = SerializeDeterministically(LatentSnapshot());
  inputs.snapshot = snapshot;
  return MakeContent(inputs).value();
}

}  // namespace sinew::bundle::testing
