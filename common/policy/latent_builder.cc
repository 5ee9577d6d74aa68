#include "common/policy/latent_builder.h"

#include <string>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "absl/types/span.h"
#include "common/policy/graph_error.h"
#include "common/policy/graph_writer.h"
#include "common/policy/latent_graphs.h"
#include "common/policy/layers.h"
#include "common/policy/validate.h"
#include "common/status_macros.h"

namespace sinew::policy {
namespace {

using internal::Bad;
using internal::CheckPositive;
using internal::CheckWidth;
using internal::CheckWidths;
using internal::GraphWriter;
using internal::Value;

constexpr char kHalf[] = "latent/half";

absl::Status CheckLatent(const v1::Latent& latent) {
  SINEW_RETURN_IF_ERROR(CheckWidth("network.latent.width", latent.width()));
  SINEW_RETURN_IF_ERROR(
      CheckWidths("network.latent.encoder_hidden", latent.encoder_hidden()));
  SINEW_RETURN_IF_ERROR(
      CheckWidths("network.latent.prior_hidden", latent.prior_hidden()));
  SINEW_RETURN_IF_ERROR(
      CheckWidths("network.latent.decoder_hidden", latent.decoder_hidden()));
  if (latent.log_variance_low() < latent.log_variance_high()) {
    return absl::OkStatus();
  }
  return Bad("network.latent.log_variance_low: expected < log_variance_high (",
             latent.log_variance_high(), "), found ",
             latent.log_variance_low());
}

absl::Status CheckOptions(const LatentPolicyOptions& options) {
  const v1::Network& network = options.network;
  SINEW_RETURN_IF_ERROR(
      CheckWidth("self_observation_width", options.self_observation_width));
  if (options.observation_width <= options.self_observation_width) {
    return Bad("observation_width: expected > self_observation_width (",
               options.self_observation_width, "), found ",
               options.observation_width);
  }
  SINEW_RETURN_IF_ERROR(CheckWidth("action_width", options.action_width));
  if (!network.has_latent()) {
    return Bad("network.latent: expected it to be set, found it unset");
  }
  SINEW_RETURN_IF_ERROR(
      CheckPositive("network.observation_clip", network.observation_clip()));
  SINEW_RETURN_IF_ERROR(
      CheckPositive("network.last_layer_gain", network.last_layer_gain()));
  SINEW_RETURN_IF_ERROR(CheckLatent(network.latent()));
  if (options.explores) {
    SINEW_RETURN_IF_ERROR(
        CheckPositive("network.initial_std", network.initial_std()));
    SINEW_RETURN_IF_ERROR(
        CheckWidths("network.value_hidden", network.value_hidden()));
  }
  return internal::ActivationOp(network.activation()).status();
}

// A mean and a standard deviation, by the names of their nodes.
struct Normal {
  std::string mean, std, log_variance;
};

// Writes one graph, piece by piece. Checked options.
class LatentGraph {
 public:
  LatentGraph(const LatentPolicyOptions& options, const std::string& name,
              v1::PolicyGraph& all)
      : options_(options),
        latent_(options.network.latent()),
        graph_(*all.add_graphs()),
        writer_(all, graph_) {
    graph_.set_name(name);
  }

  // Inputs and what is clipped of them.
  void Observation() {
    const int64_t self = options_.self_observation_width;
    const int64_t width = options_.observation_width;
    Input("observation", width, v1::GraphInput::KIND_DATA);
    own_ = Normalised(Slice("own", 0, self), "own");
    goal_ = Normalised(Slice("goal", self, width), "goal");
  }
  void SelfObservation() {
    const int64_t self = options_.self_observation_width;
    own_ = Normalised(
        Input("self_observation", self, v1::GraphInput::KIND_DATA), "own");
  }
  Value Latent() {
    return Input("latent", latent_.width(), v1::GraphInput::KIND_DATA);
  }
  void Noise() { Input("noise", latent_.width(), v1::GraphInput::KIND_NORMAL); }

  // Needs Observation.
  Normal Encoder() {
    return Distribution(Concat("encoder_input", own_, goal_),
                        latent_.encoder_hidden(), "encoder", "posterior");
  }
  Normal Prior() {
    return Distribution(own_, latent_.prior_hidden(), "prior", "prior");
  }
  // "latent" = mean + std * noise. Needs Noise.
  Value Draw(const Normal& normal) {
    writer_.Node("latent_noise", v1::OP_MULTIPLY, {normal.std, "noise"});
    writer_.Node("latent", v1::OP_ADD, {normal.mean, "latent_noise"});
    return {.name = "latent", .width = latent_.width()};
  }
  // Node and executed tap "action".
  v1::Tap& Decoder(const Value& latent) {
    DecoderLayers(latent, "action");
    v1::Tap& tap = writer_.Tap("action", "action");
    tap.set_executed(true);
    return tap;
  }
  // The same of a policy that explores: the decoder's action is its mean.
  void ExploringDecoder(const Value& latent) {
    DecoderLayers(latent, "mean");
    internal::AddExploration("action_noise", options_.action_width, writer_);
  }
  // Needs Observation.
  void Critic() {
    const Value hidden = Hidden(Concat("critic_input", own_, goal_),
                                options_.network.value_hidden(), "critic");
    Linear("value", hidden, "critic/value", 1);
    Tap("value", "value");
  }

  v1::Tap& Tap(const std::string& name, const std::string& value) {
    return writer_.Tap(name, value);
  }
  void Taps(const Normal& normal) {
    Tap("mean", normal.mean);
    Tap("std", normal.std);
    Tap("log_variance", normal.log_variance);
  }

 private:
  Value Input(const std::string& name, int64_t width,
              v1::GraphInput::Kind kind) {
    writer_.Input(name, width, kind);
    return {.name = name, .width = width};
  }
  // Columns of the observation.
  Value Slice(const std::string& name, int64_t begin, int64_t end) {
    v1::Node& node = writer_.Node(name, v1::OP_SLICE, {"observation"});
    node.set_begin(begin);
    node.set_end(end);
    return {.name = name, .width = end - begin};
  }
  Value Normalised(const Value& input, const std::string& name) {
    return internal::AddNormalised(
        input, name + "_", absl::StrCat("normaliser/", name, "/"),
        options_.network.observation_clip(), writer_);
  }
  Value Concat(const std::string& name, const Value& a, const Value& b) {
    writer_.Node(name, v1::OP_CONCAT, {a.name, b.name});
    return {.name = name, .width = a.width + b.width};
  }
  Value Hidden(const Value& input, absl::Span<const int32_t> widths,
               const std::string& part) {
    return internal::AddHidden(
        input,
        {.widths = widths,
         .activation = *internal::ActivationOp(options_.network.activation()),
         .nodes = part + "_",
         .layers = part},
        writer_);
  }
  void Linear(const std::string& node, const Value& input,
              const std::string& parameters, int64_t width) {
    writer_.Linear(node, input.name, parameters, {width, input.width},
                   /*frozen=*/false);
  }

  // The last of them is the node `action`.
  void DecoderLayers(const Value& latent, const std::string& action) {
    const Value hidden = Hidden(Concat("decoder_input", own_, latent),
                                latent_.decoder_hidden(), "decoder");
    Linear(action, hidden, "decoder/action", options_.action_width);
  }

  Normal Distribution(const Value& input, absl::Span<const int32_t> widths,
                      const std::string& part, const std::string& prefix) {
    const Value hidden = Hidden(input, widths, part);
    const Normal normal = {.mean = prefix + "_mean",
                           .std = prefix + "_std",
                           .log_variance = prefix + "_log_variance"};
    Linear(normal.mean, hidden, part + "/mean", latent_.width());
    const std::string free = normal.log_variance + "_free";
    Linear(free, hidden, part + "/log_variance", latent_.width());
    v1::Node& clamp = writer_.Node(normal.log_variance, v1::OP_CLAMP, {free});
    clamp.set_low(latent_.log_variance_low());
    clamp.set_high(latent_.log_variance_high());
    writer_.Parameter(kHalf, {latent_.width()}, /*frozen=*/true);
    const std::string half = prefix + "_half_log_variance";
    writer_.Node(half, v1::OP_AFFINE, {normal.log_variance}, {kHalf});
    writer_.Node(normal.std, v1::OP_EXP, {half});
    return normal;
  }

  const LatentPolicyOptions& options_;
  const v1::Latent& latent_;
  v1::Graph& graph_;
  GraphWriter writer_;
  Value own_, goal_;
};

void AddPolicy(const LatentPolicyOptions& options, v1::PolicyGraph& all) {
  LatentGraph graph(options, "policy", all);
  graph.Observation();
  graph.Noise();
  const Value latent = graph.Draw(graph.Encoder());
  if (options.explores) {
    graph.ExploringDecoder(latent);
    graph.Tap("latent_noise", "noise").set_recorded(true);
  } else {
    graph.Decoder(latent).set_recorded(true);
    graph.Tap("mean", "action").set_recorded(true);
  }
  graph.Tap("latent", "latent");
}

void AddEncoder(const LatentPolicyOptions& options, v1::PolicyGraph& all) {
  LatentGraph graph(options, kEncoderGraph, all);
  graph.Observation();
  graph.Taps(graph.Encoder());
}

void AddPrior(const LatentPolicyOptions& options, v1::PolicyGraph& all) {
  LatentGraph graph(options, kPriorGraph, all);
  graph.SelfObservation();
  graph.Taps(graph.Prior());
}

void AddDecoder(const LatentPolicyOptions& options, v1::PolicyGraph& all) {
  LatentGraph graph(options, kDecoderGraph, all);
  graph.SelfObservation();
  graph.Decoder(graph.Latent());
}

void AddSample(const LatentPolicyOptions& options, v1::PolicyGraph& all) {
  LatentGraph graph(options, kSampleGraph, all);
  graph.SelfObservation();
  graph.Noise();
  graph.Decoder(graph.Draw(graph.Prior()));
  graph.Tap("latent", "latent");
}

void AddCritic(const LatentPolicyOptions& options, v1::PolicyGraph& all) {
  LatentGraph graph(options, "critic", all);
  graph.Observation();
  graph.Critic();
}

}  // namespace

absl::StatusOr<v1::PolicyGraph> BuildLatentPolicy(
    const LatentPolicyOptions& options) {
  SINEW_RETURN_IF_ERROR(CheckOptions(options));
  v1::PolicyGraph graph;
  graph.set_format_version(1);
  AddPolicy(options, graph);
  AddEncoder(options, graph);
  AddPrior(options, graph);
  AddDecoder(options, graph);
  AddSample(options, graph);
  if (options.explores) AddCritic(options, graph);
  SINEW_RETURN_IF_ERROR(ValidateGraph(graph));
  return graph;
}

}  // namespace sinew::policy
