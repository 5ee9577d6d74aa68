#include "learner/ppo/ppo_networks.h"

#include <ATen/ATen.h>
#include <c10/core/GradMode.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "common/check.h"
#include "common/policy/validate.h"
#include "common/status_macros.h"
#include "learner/torch/host_view.h"
#include "learner/torch/latent_loss.h"
#include "learner/torch/parameter_buffer.h"
#include "learner/torch/runtime.h"
#include "learner/torch/torch_guard.h"
#include "learner/torch/trained_network.h"
#include "learner/update/training_graph.h"

namespace sinew::learner {
namespace {

using at::Tensor;

// Largest |log ratio| that enters the loss: exp(20) is finite in float32.
constexpr double kLargestLogRatio = 20;

constexpr char kObservation[] = "observation";

at::Device DeviceOf(const std::string& name) {
  return at::Device(name == "cuda" ? at::kCUDA : at::kCPU);
}

// The batch's columns that losses read.
struct Targets {
  Tensor action, action_mean;                       // [N, A]
  Tensor log_probability, advantage, value_target;  // [N]
  Tensor weight, acted;                             // [N]
};

class Networks final : public PpoNetworks {
 public:
  Networks(TrainingGraph policy, const Options& options)
      : policy_(std::move(policy)),
        options_(options),
        device_(DeviceOf(options.device)),
        parameters_(graph(), AllParameters(graph()), device_) {}

  // Throws c10::Error.
  absl::Status Initialise();

  absl::Status Reserve(int64_t rows) override {
    return CatchTorch("reserving a batch", [&] {
      for (auto& network : networks_) network->Reserve(rows);
      return absl::OkStatus();
    });
  }

  absl::Status LoadObservations(int64_t first_row,
                                absl::Span<const float> observations,
                                absl::Span<const float> latent_noise) override {
    if (observations.empty()) return absl::OkStatus();
    return CatchTorch("loading observations", [&] {
      const int64_t rows =
          static_cast<int64_t>(observations.size()) / policy_.observation_width;
      const Tensor inputs =
          HostView(observations, {rows, policy_.observation_width}, at::kFloat)
              .to(device_);
      std::vector<Tensor> of_policy = {inputs};
      if (policy_.latent_width > 0) {
        of_policy.push_back(LatentNoise(rows, latent_noise));
      }
      Of(NetworkId::kPolicy).Load(first_row, of_policy);
      Of(NetworkId::kValue).Load(first_row, {inputs});
      return absl::OkStatus();
    });
  }

  absl::Status Values(int64_t first_row, absl::Span<float> values) override {
    return CatchTorch("computing values", [&] {
      const int64_t rows = static_cast<int64_t>(values.size());
      const Tensor result = Of(NetworkId::kValue).Forward(first_row, rows)[0];
      at::from_blob(values.data(), {rows, 1}, at::kFloat).copy_(result);
      return absl::OkStatus();
    });
  }

  absl::Status SetTargets(const Batch& batch) override {
    return CatchTorch("loading a batch", [&] {
      const int64_t rows = batch.rows();
      const auto matrix = [&](absl::Span<const float> values) {
        return HostView(values, {rows, policy_.action_width}, at::kFloat)
            .to(device_);
      };
      const auto column = [&](absl::Span<const float> values) {
        return HostView(values, {rows}, at::kFloat).to(device_);
      };
      targets_ = {matrix(batch.action()),
                  matrix(batch.action_mean()),
                  column(batch.log_probability()),
                  column(batch.advantage()),
                  column(batch.value_target()),
                  column(batch.weight()),
                  column(batch.acted())};
      return absl::OkStatus();
    });
  }

  absl::StatusOr<GradientFigures> Gradient(NetworkId network, int shard,
                                           absl::Span<const int64_t> rows,
                                           double scale) override {
    GradientFigures figures;
    SINEW_RETURN_IF_ERROR(CatchTorch("computing a gradient", [&] {
      const c10::AutoGradMode grad(true);
      const Tensor index = Index(rows);
      const Tensor loss = network == NetworkId::kPolicy
                              ? PolicyLoss(shard, index, scale, figures)
                              : ValueLoss(shard, index, scale);
      figures.loss = loss.item<double>();
      Of(network).Gradient(shard, loss);
      return absl::OkStatus();
    }));
    return figures;
  }

  absl::StatusOr<GradientFigures> PolicyFigures(absl::Span<const int64_t> rows,
                                                double scale) override {
    GradientFigures figures;
    SINEW_RETURN_IF_ERROR(CatchTorch("evaluating the policy", [&] {
      const c10::NoGradGuard no_grad;
      figures.loss =
          PolicyLoss(/*shard=*/0, Index(rows), scale, figures).item<double>();
      return absl::OkStatus();
    }));
    return figures;
  }

  absl::StatusOr<double> SumGradients(NetworkId network) override {
    double norm = 0;
    SINEW_RETURN_IF_ERROR(CatchTorch("summing gradients", [&] {
      norm = Of(network).SumGradients();
      return absl::OkStatus();
    }));
    return norm;
  }

  absl::Status Step(NetworkId network, double learning_rate,
                    double gradient_scale) override {
    return CatchTorch("taking a step", [&] {
      Of(network).Step(learning_rate, gradient_scale);
      return absl::OkStatus();
    });
  }

  NetworkFlops flops(NetworkId network) const override {
    const TrainedNetwork& one = Of(network);
    return {.load = one.load_flops(),
            .forward = one.forward_flops(),
            .backward = one.backward_flops()};
  }

  absl::Status LoadWeights(const TensorMap& weights) override {
    SINEW_RETURN_IF_ERROR(policy::ValidateGraph(graph(), weights));
    return CatchTorch("loading weights", [&]() -> absl::Status {
      SINEW_RETURN_IF_ERROR(parameters_.Load(weights, ""));
      for (auto& network : networks_) {
        SINEW_RETURN_IF_ERROR(network->weights().Load(weights, ""));
      }
      return absl::OkStatus();
    });
  }

  TensorMap SaveWeights() const override {
    TensorMap weights;
    const absl::Status saved = CatchTorch("saving weights", [&] {
      parameters_.Save("", weights);
      for (auto& network : networks_) network->weights().Save("", weights);
      return absl::OkStatus();
    });
    SINEW_CHECK(saved.ok()) << saved.ToString();
    return weights;
  }

  absl::Status LoadOptimiser(NetworkId network, const TensorMap& tensors,
                             int64_t steps) override {
    return CatchTorch("loading an optimiser",
                      [&] { return Of(network).LoadMoments(tensors, steps); });
  }

  void SaveOptimiser(NetworkId network, TensorMap& tensors) const override {
    const absl::Status saved = CatchTorch("saving an optimiser", [&] {
      Of(network).SaveMoments(tensors);
      return absl::OkStatus();
    });
    SINEW_CHECK(saved.ok()) << saved.ToString();
  }

  int64_t optimiser_steps(NetworkId network) const override {
    return Of(network).steps();
  }

 private:
  // With the policy as it is differentiated among its graphs.
  const v1::PolicyGraph& graph() const { return policy_.all; }

  TrainedNetwork& Of(NetworkId network) const {
    return *networks_[static_cast<int>(network)];
  }

  Tensor Index(absl::Span<const int64_t> rows) const {
    return HostView(rows, {static_cast<int64_t>(rows.size())}, at::kLong)
        .to(device_);
  }

  // [rows, Z], zeros where there is none.
  Tensor LatentNoise(int64_t rows, absl::Span<const float> noise) const {
    if (noise.empty()) {
      return at::zeros({rows, policy_.latent_width},
                       at::TensorOptions(device_).dtype(at::kFloat));
    }
    SINEW_CHECK(static_cast<int64_t>(noise.size()) ==
                rows * policy_.latent_width)
        << noise.size() << " " << rows << " " << policy_.latent_width;
    return HostView(noise, {rows, policy_.latent_width}, at::kFloat)
        .to(device_);
  }

  absl::Status AddNetwork(TrainedNetwork::Options options);
  absl::Status CheckNothingShared() const;
  Tensor PolicyLoss(int shard, const Tensor& index, double scale,
                    GradientFigures& figures) const;
  // What a latent adds to that; `outputs` are those of the policy.
  Tensor LatentLoss(absl::Span<const Tensor> outputs, const Tensor& weight,
                    double scale, GradientFigures& figures) const;
  Tensor ValueLoss(int shard, const Tensor& index, double scale) const;

  const TrainingGraph policy_;
  const Options options_;
  const at::Device device_;
  int std_number_ = -1;  // parameter with the Gaussian's standard deviation
  // All parameters; of those that a network trains, the network has the truth.
  ParameterBuffer parameters_;
  std::vector<std::unique_ptr<TrainedNetwork>> networks_;
  Targets targets_;
};

absl::Status Networks::Initialise() {
  SINEW_ASSIGN_OR_RETURN(const v1::Graph* policy,
                         policy::FindGraph(graph(), policy_.name));
  const v1::GaussianTap* gaussian = nullptr;
  for (const v1::Tap& tap : policy->taps()) {
    if (tap.executed() && tap.has_gaussian()) gaussian = &tap.gaussian();
  }
  if (gaussian == nullptr || gaussian->mean() != policy_.outputs[0]) {
    return absl::InvalidArgumentError(
        "graph policy: expected an executed tap with a Gaussian around the tap "
        "mean, found none");
  }
  std::vector<int> extra;
  for (int i = 0; i < graph().parameters_size(); ++i) {
    const v1::Parameter& parameter = graph().parameters(i);
    if (parameter.name() != gaussian->std_parameter()) continue;
    std_number_ = i;
    if (!parameter.frozen()) extra.push_back(i);
  }
  std::vector<std::string> inputs = {kObservation};
  if (policy_.latent_width > 0) inputs.push_back(policy_.noise);
  SINEW_RETURN_IF_ERROR(AddNetwork({.graph_name = policy_.name,
                                    .inputs = std::move(inputs),
                                    .outputs = policy_.outputs,
                                    .extra_parameters = std::move(extra)}));
  SINEW_ASSIGN_OR_RETURN(const v1::Graph* critic,
                         policy::FindGraph(graph(), "critic"));
  std::string value = "value";
  for (const v1::Tap& tap : critic->taps()) {
    if (tap.name() == value) value = tap.value();
  }
  SINEW_RETURN_IF_ERROR(AddNetwork(
      {.graph_name = "critic", .inputs = {kObservation}, .outputs = {value}}));
  return CheckNothingShared();
}

absl::Status Networks::AddNetwork(TrainedNetwork::Options options) {
  options.precision =
      options_.bfloat16 ? Precision::kBfloat16 : Precision::kFloat32;
  options.shards = options_.shards;
  SINEW_ASSIGN_OR_RETURN(
      std::unique_ptr<TrainedNetwork> network,
      TrainedNetwork::Create(graph(), options, parameters_.Views(), device_));
  networks_.push_back(std::move(network));
  return absl::OkStatus();
}

absl::Status Networks::CheckNothingShared() const {
  const std::vector<int>& policy =
      Of(NetworkId::kPolicy).weights().parameters();
  for (const int number : Of(NetworkId::kValue).weights().parameters()) {
    if (std::find(policy.begin(), policy.end(), number) == policy.end()) {
      continue;
    }
    return absl::InvalidArgumentError(absl::StrCat(
        "parameter ", graph().parameters(number).name(),
        ": expected policy and critic to train parameters of their own, found "
        "it in both"));
  }
  return absl::OkStatus();
}

Tensor Networks::PolicyLoss(int shard, const Tensor& index, double scale,
                            GradientFigures& figures) const {
  TrainedNetwork& network = Of(NetworkId::kPolicy);
  const std::vector<Tensor> outputs = network.Forward(shard, index);
  const Tensor& mean = outputs[0];
  const Tensor& std = network.Parameters(shard)[std_number_];
  const Tensor advantage = targets_.advantage.index_select(0, index);
  const Tensor weight = targets_.weight.index_select(0, index);

  const Tensor z = (targets_.action.index_select(0, index) - mean) / std;
  const Tensor log_std = std.log().sum();
  const double log_two_pi = std::log(2 * std::numbers::pi);
  const auto actions = static_cast<double>(policy_.action_width);
  const Tensor log_probability =
      -0.5 * z.square().sum(1) - log_std - 0.5 * log_two_pi * actions;
  const Tensor ratio =
      at::clamp(
          log_probability - targets_.log_probability.index_select(0, index),
          -kLargestLogRatio, kLargestLogRatio)
          .exp();
  const Tensor clipped =
      at::clamp(ratio, 1 - options_.ratio_clip, 1 + options_.ratio_clip);
  const Tensor gain = at::minimum(ratio * advantage, clipped * advantage);
  Tensor loss = (gain * weight).sum() * -scale;
  const Tensor entropy = log_std + 0.5 * (log_two_pi + 1) * actions;
  if (options_.entropy_weight != 0) {
    loss = loss - entropy * weight.sum() * (options_.entropy_weight * scale);
  }
  if (policy_.latent_width > 0) {
    loss = loss + LatentLoss(outputs, weight, scale, figures);
  }

  const c10::NoGradGuard no_grad;
  const Tensor drift =
      (mean - targets_.action_mean.index_select(0, index)) / std;
  const Tensor outside = (ratio - 1).abs() > options_.ratio_clip;
  const Tensor acted = targets_.acted.index_select(0, index);
  const Tensor sums =
      at::stack({(drift.square().sum(1) * acted).sum() * 0.5,
                 (outside * acted).sum(), entropy * weight.sum()})
          .to(at::kCPU);
  figures.kl = sums[0].item<double>();
  figures.clipped = sums[1].item<double>();
  figures.entropy = sums[2].item<double>();
  return loss;
}

Tensor Networks::LatentLoss(absl::Span<const Tensor> outputs,
                            const Tensor& weight, double scale,
                            GradientFigures& figures) const {
  const Tensor kl =
      LatentKlSum(outputs[1], outputs[2], outputs[3], outputs[4], weight);
  figures.latent_kl = kl.item<double>();
  return kl * (options_.latent_kl_weight * scale);
}

Tensor Networks::ValueLoss(int shard, const Tensor& index, double scale) const {
  const Tensor value =
      Of(NetworkId::kValue).Forward(shard, index)[0].squeeze(1);
  const Tensor error = value - targets_.value_target.index_select(0, index);
  const Tensor weight = targets_.weight.index_select(0, index);
  return (error.square() * weight).sum() * (0.5 * scale);
}

}  // namespace

absl::StatusOr<std::unique_ptr<PpoNetworks>> PpoNetworks::Create(
    const v1::PolicyGraph& graph, const TensorMap& weights,
    const Options& options) {
  SINEW_RETURN_IF_ERROR(CheckDevice(options.device));
  if (options.bfloat16) {
    SINEW_RETURN_IF_ERROR(
        CheckBfloat16(DetectCpu(), options.device, "ppo.bfloat16"));
  }
  SINEW_RETURN_IF_ERROR(policy::ValidateGraph(graph, weights));
  SINEW_ASSIGN_OR_RETURN(TrainingGraph policy, MakeTrainingGraph(graph));
  std::unique_ptr<Networks> networks;
  SINEW_RETURN_IF_ERROR(CatchTorch("creating networks", [&]() -> absl::Status {
    networks = std::make_unique<Networks>(std::move(policy), options);
    return networks->Initialise();
  }));
  SINEW_RETURN_IF_ERROR(networks->LoadWeights(weights));
  return networks;
}

}  // namespace sinew::learner
