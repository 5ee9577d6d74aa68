#include "learner/torch/torch_runner.h"

#include <ATen/ATen.h>
#include <c10/core/GradMode.h>
#include <torch/csrc/autograd/autograd.h>

#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/string_view.h"
#include "common/policy/validate.h"
#include "common/status_macros.h"
#include "learner/torch/graph_module.h"
#include "learner/torch/parameter_buffer.h"
#include "learner/torch/runtime.h"
#include "learner/torch/torch_guard.h"

namespace sinew::learner {
namespace {

class Runner final : public TorchRunner {
 public:
  Runner(const v1::PolicyGraph& all, std::unique_ptr<const GraphModule> module,
         std::map<std::string, int64_t> widths, const at::Device& device)
      : module_(std::move(module)),
        widths_(std::move(widths)),
        weights_(all, AllParameters(all), device),
        names_(Names(all)) {}

  absl::Status Load(const TensorMap& weights) {
    return CatchTorch("loading weights",
                      [&] { return weights_.Load(weights, ""); });
  }

  absl::StatusOr<Rows> Run(int64_t batch, const Rows& inputs) const override {
    std::vector<std::string> values;
    for (const v1::Tap& tap : module_->graph().taps()) {
      values.push_back(tap.value());
    }
    Rows rows;
    SINEW_RETURN_IF_ERROR(CatchTorch("running a graph", [&]() -> absl::Status {
      UseOneThread();
      const c10::NoGradGuard no_grad;
      SINEW_ASSIGN_OR_RETURN(const GraphPlan plan,
                             module_->MakePlan(InputNames(), values));
      SINEW_ASSIGN_OR_RETURN(const std::vector<at::Tensor> given,
                             Given(batch, inputs));
      const auto results = module_->Run(plan, given, weights_.Views());
      for (int i = 0; i < module_->graph().taps_size(); ++i) {
        const at::Tensor host = results[i].to(at::kCPU).contiguous();
        rows[module_->graph().taps(i).name()].assign(
            host.data_ptr<float>(), host.data_ptr<float>() + host.numel());
      }
      return absl::OkStatus();
    }));
    return rows;
  }

  absl::StatusOr<TensorMap> Gradient(
      int64_t batch, const Rows& inputs, const std::string& tap,
      const std::vector<float>& cotangent) const override {
    const v1::Tap* found = nullptr;
    for (const v1::Tap& one : module_->graph().taps()) {
      if (one.name() == tap) found = &one;
    }
    if (found == nullptr) {
      return absl::NotFoundError(absl::StrCat("no tap \"", tap, "\""));
    }
    TensorMap gradients;
    SINEW_RETURN_IF_ERROR(CatchTorch("differentiating", [&]() -> absl::Status {
      UseOneThread();
      SINEW_ASSIGN_OR_RETURN(const GraphPlan plan,
                             module_->MakePlan(InputNames(), {found->value()}));
      SINEW_ASSIGN_OR_RETURN(const std::vector<at::Tensor> given,
                             Given(batch, inputs));
      SINEW_ASSIGN_OR_RETURN(
          const at::Tensor seed,
          Matrix("cotangent", cotangent, batch, widths_.at(found->value())));
      const std::vector<at::Tensor> leaves = weights_.Leaves();
      const auto results = module_->Run(plan, given, leaves);
      const std::vector<int> numbers = module_->TrainedParameters(plan);
      std::vector<at::Tensor> trained;
      for (const int number : numbers) trained.push_back(leaves[number]);
      const auto parts = torch::autograd::grad({results[0]}, trained, {seed});
      for (size_t i = 0; i < numbers.size(); ++i) {
        const at::Tensor host = parts[i].to(at::kCPU).contiguous();
        gradients[names_[numbers[i]]] = HostTensor::Float32(
            host.sizes().vec(),
            {host.data_ptr<float>(), static_cast<size_t>(host.numel())});
      }
      return absl::OkStatus();
    }));
    return gradients;
  }

 private:
  static std::vector<std::string> Names(const v1::PolicyGraph& all) {
    std::vector<std::string> names;
    for (const v1::Parameter& one : all.parameters()) {
      names.push_back(one.name());
    }
    return names;
  }

  std::vector<std::string> InputNames() const {
    std::vector<std::string> names;
    for (const v1::GraphInput& one : module_->graph().inputs()) {
      names.push_back(one.name());
    }
    return names;
  }

  absl::StatusOr<at::Tensor> Matrix(const std::string& name,
                                    const std::vector<float>& values,
                                    int64_t batch, int64_t width) const {
    if (static_cast<int64_t>(values.size()) != batch * width) {
      return absl::InvalidArgumentError(
          absl::StrCat(name, ": expected ", batch, " x ", width,
                       " numbers, found ", values.size()));
    }
    void* data = const_cast<float*>(values.data());
    return at::from_blob(data, {batch, width}, at::kFloat)
        .to(weights_.flat().device(), /*non_blocking=*/false, /*copy=*/true);
  }

  absl::StatusOr<std::vector<at::Tensor>> Given(int64_t batch,
                                                const Rows& inputs) const {
    std::vector<at::Tensor> given;
    for (const v1::GraphInput& input : module_->graph().inputs()) {
      const auto found = inputs.find(input.name());
      if (found == inputs.end()) {
        given.push_back(
            at::zeros({batch, input.width()}, weights_.flat().options()));
        continue;
      }
      SINEW_ASSIGN_OR_RETURN(
          at::Tensor rows,
          Matrix(input.name(), found->second, batch, input.width()));
      given.push_back(std::move(rows));
    }
    return given;
  }

  const std::unique_ptr<const GraphModule> module_;
  const std::map<std::string, int64_t> widths_;
  ParameterBuffer weights_;
  const std::vector<std::string> names_;
};

}  // namespace

absl::StatusOr<std::unique_ptr<TorchRunner>> TorchRunner::Create(
    const v1::PolicyGraph& graph, absl::string_view graph_name,
    const TensorMap& weights, const Options& options) {
  using Widths = std::map<std::string, int64_t>;
  SINEW_RETURN_IF_ERROR(CheckDevice(options.device));
  SINEW_RETURN_IF_ERROR(policy::ValidateGraph(graph, weights));
  SINEW_ASSIGN_OR_RETURN(
      std::unique_ptr<const GraphModule> module,
      GraphModule::Create(
          graph, graph_name,
          options.bfloat16 ? Precision::kBfloat16 : Precision::kFloat32));
  SINEW_ASSIGN_OR_RETURN(Widths widths, policy::InferWidths(graph, graph_name));
  std::unique_ptr<Runner> runner;
  SINEW_RETURN_IF_ERROR(CatchTorch("creating a graph", [&] {
    runner = std::make_unique<Runner>(
        graph, std::move(module), std::move(widths),
        at::Device(options.device == "cuda" ? at::kCUDA : at::kCPU));
    return runner->Load(weights);
  }));
  return runner;
}

}  // namespace sinew::learner
