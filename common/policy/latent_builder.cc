#include "common/policy/latent_builder.h"

#include <numbers>
#include <string>

#include "absl/status/status.h"
#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/string_view.h"
#include "absl/types/span.h"
#include "common/policy/graph_error.h"
#include "common/policy/graph_writer.h"
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
    const Value hidden = Hidden(Concat("decoder_input", own_, latent),
                                latent_.decoder_hidden(), "decoder");
    Linear("action", hidden, "decoder/action", options_.action_width);
    v1::Tap& tap = writer_.Tap("action", "action");
    tap.set_executed(true);
    return tap;
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
  graph.Decoder(graph.Draw(graph.Encoder())).set_recorded(true);
  graph.Tap("mean", "action").set_recorded(true);
  graph.Tap("latent", "latent");
}

void AddEncoder(const LatentPolicyOptions& options, v1::PolicyGraph& all) {
  LatentGraph graph(options, "encoder", all);
  graph.Observation();
  graph.Taps(graph.Encoder());
}

void AddPrior(const LatentPolicyOptions& options, v1::PolicyGraph& all) {
  LatentGraph graph(options, "prior", all);
  graph.SelfObservation();
  graph.Taps(graph.Prior());
}

void AddDecoder(const LatentPolicyOptions& options, v1::PolicyGraph& all) {
  LatentGraph graph(options, "decoder", all);
  graph.SelfObservation();
  graph.Decoder(graph.Latent());
}

void AddSample(const LatentPolicyOptions& options, v1::PolicyGraph& all) {
  LatentGraph graph(options, "sample", all);
  graph.SelfObservation();
  graph.Noise();
  graph.Decoder(graph.Draw(graph.Prior()));
  graph.Tap("latent", "latent");
}

bool IsLastLayer(absl::string_view weight) {
  return absl::EndsWith(weight, "/mean/weight") ||
         absl::EndsWith(weight, "/log_variance/weight") ||
         weight == "decoder/action/weight";
}

double InitialConstant(absl::string_view name) {
  if (name == kHalf) return 0.5;
  return absl::EndsWith(name, "/inverse_std") ? 1.0 : 0.0;
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
  SINEW_RETURN_IF_ERROR(ValidateGraph(graph));
  return graph;
}

absl::StatusOr<TensorMap> InitialLatentWeights(
    const LatentPolicyOptions& options, uint64_t seed) {
  SINEW_ASSIGN_OR_RETURN(const v1::PolicyGraph graph,
                         BuildLatentPolicy(options));
  const double last = options.network.last_layer_gain();
  return internal::DrawWeights(
      graph, seed,
      {.gain =
           [last](const std::string& name) {
             return IsLastLayer(name) ? last : std::numbers::sqrt2;
           },
       .constant =
           [](const std::string& name) { return InitialConstant(name); }});
}

}  // namespace sinew::policy
