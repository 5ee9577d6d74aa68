#include "learner/distillation/distillation_networks.h"

#include <ATen/ATen.h>
#include <c10/core/GradMode.h>

#include <utility>

#include "absl/strings/str_cat.h"
#include "common/check.h"
#include "common/policy/validate.h"
#include "common/status_macros.h"
#include "learner/distillation/distillation_loss.h"
#include "learner/torch/host_view.h"
#include "learner/torch/parameter_buffer.h"
#include "learner/torch/runtime.h"
#include "learner/torch/torch_guard.h"
#include "learner/torch/trained_network.h"
#include "learner/update/training_graph.h"

namespace sinew::learner {
namespace {

using at::Tensor;

constexpr char kObservation[] = "observation";

class Networks final : public DistillationNetworks {
 public:
  Networks(TrainingGraph graph, const Options& options)
      : graph_(std::move(graph)),
        options_(options),
        device_(options.device == "cuda" ? at::kCUDA : at::kCPU),
        parameters_(graph_.all, AllParameters(graph_.all), device_) {}

  // Throws c10::Error.
  absl::Status Initialise();

  int64_t latent_width() const override { return graph_.latent_width; }

  absl::StatusOr<Figures> Gradient(int shard, const Rows& rows,
                                   const Weights& weights) override {
    Figures figures;
    SINEW_RETURN_IF_ERROR(CatchTorch("computing a gradient", [&] {
      const c10::AutoGradMode grad(true);
      const DistillationTensors tensors = Forward(shard, rows);
      const DistillationTerms terms =
          DistillationLoss(tensors, options_.steps,
                           {.form = options_.form,
                            .kl = weights.kl,
                            .continuity = weights.continuity,
                            .row_scale = weights.row_scale,
                            .pair_scale = weights.pair_scale});
      Measure(tensors, terms, figures);
      network_->Gradient(shard, terms.loss);
      return absl::OkStatus();
    }));
    return figures;
  }

  absl::StatusOr<double> SumGradients() override {
    double norm = 0;
    SINEW_RETURN_IF_ERROR(CatchTorch("summing gradients", [&] {
      norm = network_->SumGradients();
      return absl::OkStatus();
    }));
    return norm;
  }

  absl::Status Step(double learning_rate, double gradient_scale) override {
    return CatchTorch("taking a step", [&] {
      network_->Step(learning_rate, gradient_scale);
      return absl::OkStatus();
    });
  }

  TensorMap gradient() const override {
    TensorMap gradient;
    const absl::Status saved = CatchTorch("saving a gradient", [&] {
      network_->gradient().Save("", gradient);
      return absl::OkStatus();
    });
    SINEW_CHECK(saved.ok()) << saved.ToString();
    return gradient;
  }

  double flops_per_row() const override {
    return network_->load_flops() + network_->forward_flops() +
           network_->backward_flops();
  }

  absl::Status LoadWeights(const TensorMap& weights) override {
    SINEW_RETURN_IF_ERROR(policy::ValidateGraph(graph_.all, weights));
    return CatchTorch("loading weights", [&]() -> absl::Status {
      SINEW_RETURN_IF_ERROR(parameters_.Load(weights, ""));
      return network_->weights().Load(weights, "");
    });
  }

  TensorMap SaveWeights() const override {
    TensorMap weights;
    const absl::Status saved = CatchTorch("saving weights", [&] {
      parameters_.Save("", weights);
      network_->weights().Save("", weights);
      return absl::OkStatus();
    });
    SINEW_CHECK(saved.ok()) << saved.ToString();
    return weights;
  }

  absl::Status LoadOptimiser(const TensorMap& tensors, int64_t steps) override {
    return CatchTorch("loading an optimiser",
                      [&] { return network_->LoadMoments(tensors, steps); });
  }

  void SaveOptimiser(TensorMap& tensors) const override {
    const absl::Status saved = CatchTorch("saving an optimiser", [&] {
      network_->SaveMoments(tensors);
      return absl::OkStatus();
    });
    SINEW_CHECK(saved.ok()) << saved.ToString();
  }

  int64_t optimiser_steps() const override { return network_->steps(); }

 private:
  Tensor Matrix(absl::Span<const float> values, int64_t width) const {
    return HostView(values, {options_.shard_rows, width}, at::kFloat)
        .to(device_);
  }
  Tensor Column(absl::Span<const float> values) const {
    return HostView(values, {options_.shard_rows}, at::kFloat).to(device_);
  }

  DistillationTensors Forward(int shard, const Rows& rows);
  void Measure(const DistillationTensors& tensors,
               const DistillationTerms& terms, Figures& figures) const;

  const TrainingGraph graph_;
  const Options options_;
  const at::Device device_;
  Tensor scale_;  // [A]
  // All parameters; of those that are trained, the network has the truth.
  ParameterBuffer parameters_;
  std::unique_ptr<TrainedNetwork> network_;
};

absl::Status Networks::Initialise() {
  std::vector<std::string> inputs = {kObservation};
  if (!graph_.noise.empty()) inputs.push_back(graph_.noise);
  SINEW_ASSIGN_OR_RETURN(
      network_, TrainedNetwork::Create(
                    graph_.all,
                    {.graph_name = graph_.name,
                     .inputs = std::move(inputs),
                     .outputs = graph_.outputs,
                     .precision = options_.bfloat16 ? Precision::kBfloat16
                                                    : Precision::kFloat32,
                     .shards = options_.shards},
                    parameters_.Views(), device_));
  scale_ = HostView(absl::MakeConstSpan(options_.action_scale),
                    {graph_.action_width}, at::kDouble)
               .clone()
               .to(device_, at::kFloat);
  return absl::OkStatus();
}

DistillationTensors Networks::Forward(int shard, const Rows& rows) {
  std::vector<Tensor> inputs = {
      Matrix(rows.observation, graph_.observation_width)};
  if (graph_.latent_width > 0) {
    inputs.push_back(Matrix(rows.noise, graph_.latent_width));
  }
  const std::vector<Tensor> outputs = network_->ForwardInputs(shard, inputs);
  DistillationTensors tensors;
  tensors.action = outputs[0];
  tensors.label = Matrix(rows.label, graph_.action_width);
  tensors.valid = Column(rows.valid);
  tensors.linked = Column(rows.linked);
  if (graph_.latent_width == 0) return tensors;
  tensors.posterior_mean = outputs[1];
  tensors.posterior_log_variance = outputs[2];
  tensors.prior_mean = outputs[3];
  tensors.prior_log_variance = outputs[4];
  return tensors;
}

void Networks::Measure(const DistillationTensors& tensors,
                       const DistillationTerms& terms, Figures& figures) const {
  const c10::NoGradGuard no_grad;
  figures.loss = terms.loss.item<double>();
  figures.action = terms.action.item<double>();
  if (terms.latent_kl.defined()) {
    figures.latent_kl = terms.latent_kl.item<double>();
    figures.continuity = terms.continuity.item<double>();
  }
  const Tensor error = (tensors.action - tensors.label) * scale_;
  figures.squared_error_rad2 =
      (error.square().sum(1) * tensors.valid).sum().item<double>();
  const Tensor counts =
      at::clamp_min(tensors.valid.view({-1, options_.steps}).sum(1), 1);
  const Tensor losses =
      (terms.row_action.view({-1, options_.steps}).sum(1) / counts)
          .to(at::kCPU)
          .contiguous();
  figures.sequence_loss.assign(losses.data_ptr<float>(),
                               losses.data_ptr<float>() + losses.numel());
}

absl::Status CheckOptions(const DistillationNetworks::Options& options,
                          const TrainingGraph& graph) {
  if (options.shards < 1 || options.steps < 1 || options.shard_rows < 1 ||
      options.shard_rows % options.steps != 0) {
    return absl::InvalidArgumentError(absl::StrCat(
        "shards: expected >= 1 of whole sequences of ", options.steps,
        " rows, found ", options.shards, " of ", options.shard_rows));
  }
  if (static_cast<int64_t>(options.action_scale.size()) == graph.action_width) {
    return absl::OkStatus();
  }
  return absl::InvalidArgumentError(absl::StrCat(
      "action_scale: expected ", graph.action_width,
      " numbers, one per action, found ", options.action_scale.size()));
}

}  // namespace

absl::StatusOr<std::unique_ptr<DistillationNetworks>>
DistillationNetworks::Create(const v1::PolicyGraph& graph,
                             const TensorMap& weights, const Options& options) {
  SINEW_RETURN_IF_ERROR(CheckDevice(options.device));
  if (options.bfloat16) {
    SINEW_RETURN_IF_ERROR(
        CheckBfloat16(DetectCpu(), options.device, "distillation.bfloat16"));
  }
  SINEW_RETURN_IF_ERROR(policy::ValidateGraph(graph, weights));
  SINEW_ASSIGN_OR_RETURN(TrainingGraph training, MakeTrainingGraph(graph));
  SINEW_RETURN_IF_ERROR(CheckOptions(options, training));
  std::unique_ptr<Networks> networks;
  SINEW_RETURN_IF_ERROR(CatchTorch("creating networks", [&]() -> absl::Status {
    networks = std::make_unique<Networks>(std::move(training), options);
    return networks->Initialise();
  }));
  SINEW_RETURN_IF_ERROR(networks->LoadWeights(weights));
  return networks;
}

}  // namespace sinew::learner
