#include "learner/torch/trained_network.h"

#include <ATen/ATen.h>
#include <c10/core/GradMode.h>
#include <torch/csrc/autograd/autograd.h>

#include <algorithm>
#include <utility>

#include "common/status_macros.h"

namespace sinew::learner {
namespace {

constexpr double kBeta1 = 0.9;
constexpr double kBeta2 = 0.999;
constexpr double kEpsilon = 1e-8;
constexpr char kFirstMoment[] = "adam/first_moment/";
constexpr char kSecondMoment[] = "adam/second_moment/";

}  // namespace

TrainedNetwork::TrainedNetwork(const v1::PolicyGraph& graph,
                               std::unique_ptr<const GraphModule> module,
                               const std::vector<int>& trained,
                               const at::Device& device)
    : module_(std::move(module)),
      weights_(graph, trained, device),
      first_moment_(graph, trained, device),
      second_moment_(graph, trained, device) {}

absl::StatusOr<std::unique_ptr<TrainedNetwork>> TrainedNetwork::Create(
    const v1::PolicyGraph& graph, const Options& options,
    absl::Span<const at::Tensor> frozen, const at::Device& device) {
  SINEW_ASSIGN_OR_RETURN(
      std::unique_ptr<const GraphModule> module,
      GraphModule::Create(graph, options.graph_name, options.precision));
  const std::vector<std::string> frontier =
      module->FrozenFrontier(options.outputs);
  SINEW_ASSIGN_OR_RETURN(GraphPlan prefix,
                         module->MakePlan(options.inputs, frontier));
  SINEW_ASSIGN_OR_RETURN(GraphPlan plan,
                         module->MakePlan(frontier, options.outputs));
  std::vector<int> trained = module->TrainedParameters(plan);
  trained.insert(trained.end(), options.extra_parameters.begin(),
                 options.extra_parameters.end());
  std::sort(trained.begin(), trained.end());
  std::unique_ptr<TrainedNetwork> network(
      new TrainedNetwork(graph, std::move(module), trained, device));
  network->prefix_ = std::move(prefix);
  network->plan_ = std::move(plan);
  network->frozen_.assign(frozen.begin(), frozen.end());
  for (int s = 0; s < options.shards; ++s) {
    Shard shard{network->weights_.Leaves(), network->frozen_,
                ParameterBuffer(graph, trained, device)};
    for (size_t i = 0; i < trained.size(); ++i) {
      shard.parameters[trained[i]] = shard.leaves[i];
    }
    network->shards_.push_back(std::move(shard));
  }
  return network;
}

void TrainedNetwork::Reserve(int64_t rows) {
  if (!frontier_.empty() && frontier_[0].size(0) == rows) return;
  frontier_.clear();
  // One row through the prefix tells the widths.
  const c10::NoGradGuard no_grad;
  std::vector<at::Tensor> row;
  for (const int input : prefix_.given) {
    row.push_back(at::zeros({1, module_->graph().inputs(input).width()},
                            weights_.flat().options()));
  }
  for (const at::Tensor& value : module_->Run(prefix_, row, frozen_)) {
    frontier_.push_back(at::empty({rows, value.size(1)}, value.options()));
  }
}

void TrainedNetwork::Load(int64_t first_row,
                          absl::Span<const at::Tensor> inputs) {
  const c10::NoGradGuard no_grad;
  const auto values = module_->Run(prefix_, inputs, frozen_);
  for (size_t i = 0; i < values.size(); ++i) {
    frontier_[i].narrow(0, first_row, values[i].size(0)).copy_(values[i]);
  }
}

std::vector<at::Tensor> TrainedNetwork::Forward(int64_t first_row,
                                                int64_t rows) const {
  const c10::NoGradGuard no_grad;
  std::vector<at::Tensor> given;
  for (const at::Tensor& value : frontier_) {
    given.push_back(value.narrow(0, first_row, rows));
  }
  return module_->Run(plan_, given, shards_[0].parameters);
}

std::vector<at::Tensor> TrainedNetwork::ForwardInputs(
    int shard, absl::Span<const at::Tensor> inputs) const {
  std::vector<at::Tensor> given;
  {
    const c10::NoGradGuard no_grad;
    given = module_->Run(prefix_, inputs, frozen_);
  }
  return module_->Run(plan_, given, shards_[shard].parameters);
}

std::vector<at::Tensor> TrainedNetwork::Forward(int shard,
                                                const at::Tensor& rows) const {
  std::vector<at::Tensor> given;
  for (const at::Tensor& value : frontier_) {
    given.push_back(value.index_select(0, rows));
  }
  return module_->Run(plan_, given, shards_[shard].parameters);
}

void TrainedNetwork::Gradient(int shard, const at::Tensor& loss) {
  Shard& own = shards_[shard];
  const auto parts = torch::autograd::grad({loss}, own.leaves);
  const c10::NoGradGuard no_grad;
  for (size_t i = 0; i < parts.size(); ++i) {
    own.gradient.View(i).copy_(parts[i]);
  }
}

double TrainedNetwork::SumGradients() {
  const c10::NoGradGuard no_grad;
  const at::Tensor& sum = shards_[0].gradient.flat();
  for (size_t s = 1; s < shards_.size(); ++s) {
    sum.add_(shards_[s].gradient.flat());
  }
  return sum.norm().item<double>();
}

void TrainedNetwork::Step(double learning_rate, double gradient_scale) {
  const c10::NoGradGuard no_grad;
  ++steps_;
  const at::Tensor& gradient = shards_[0].gradient.flat();
  if (gradient_scale != 1.0) gradient.mul_(gradient_scale);
  const at::Tensor step =
      at::full({}, static_cast<double>(steps_), gradient.options());
  at::_fused_adam_({weights_.flat()}, {gradient}, {first_moment_.flat()},
                   {second_moment_.flat()}, {}, {step}, learning_rate, kBeta1,
                   kBeta2, /*weight_decay=*/0, kEpsilon, /*amsgrad=*/false,
                   /*maximize=*/false);
}

absl::Status TrainedNetwork::LoadMoments(const TensorMap& tensors,
                                         int64_t steps) {
  SINEW_RETURN_IF_ERROR(first_moment_.Load(tensors, kFirstMoment));
  SINEW_RETURN_IF_ERROR(second_moment_.Load(tensors, kSecondMoment));
  steps_ = steps;
  return absl::OkStatus();
}

void TrainedNetwork::SaveMoments(TensorMap& tensors) const {
  first_moment_.Save(kFirstMoment, tensors);
  second_moment_.Save(kSecondMoment, tensors);
}

}  // namespace sinew::learner
