#include "learner/torch/parameter_buffer.h"

#include <ATen/ATen.h>

#include <algorithm>
#include <numeric>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"

namespace sinew::learner {
namespace {

constexpr int64_t kAlignment = 16;  // elements

}  // namespace

ParameterBuffer::ParameterBuffer(const v1::PolicyGraph& graph,
                                 std::vector<int> parameters,
                                 const at::Device& device)
    : numbers_(std::move(parameters)) {
  int64_t end = 0;
  for (const int number : numbers_) {
    const v1::Parameter& parameter = graph.parameters(number);
    Slot slot{parameter.name(),
              {parameter.shape().begin(), parameter.shape().end()},
              end,
              1};
    for (const int64_t extent : slot.shape) slot.size *= extent;
    end += (slot.size + kAlignment - 1) / kAlignment * kAlignment;
    slots_.push_back(std::move(slot));
  }
  flat_ = at::zeros({end}, at::TensorOptions(at::kFloat).device(device));
}

at::Tensor ParameterBuffer::View(size_t i) const {
  const Slot& slot = slots_[i];
  return flat_.narrow(0, slot.offset, slot.size).view(slot.shape);
}

std::vector<at::Tensor> ParameterBuffer::Views() const {
  std::vector<at::Tensor> views;
  for (size_t i = 0; i < slots_.size(); ++i) views.push_back(View(i));
  return views;
}

std::vector<at::Tensor> ParameterBuffer::Leaves() const {
  std::vector<at::Tensor> leaves;
  for (size_t i = 0; i < slots_.size(); ++i) {
    leaves.push_back(View(i).detach().set_requires_grad(true));
  }
  return leaves;
}

absl::Status ParameterBuffer::Load(const TensorMap& tensors,
                                   const std::string& prefix) {
  for (const Slot& slot : slots_) {
    const auto found = tensors.find(prefix + slot.name);
    if (found == tensors.end()) {
      return absl::InvalidArgumentError(
          absl::StrCat("tensor ", prefix, slot.name, ": missing"));
    }
    const HostTensor& tensor = found->second;
    if (tensor.dtype != v1::DATA_TYPE_FLOAT32 || tensor.shape != slot.shape ||
        tensor.data.size() != slot.size * sizeof(float)) {
      return absl::InvalidArgumentError(
          absl::StrCat("tensor ", prefix, slot.name, ": expected float32 [",
                       absl::StrJoin(slot.shape, ", "), "], found ",
                       v1::DataType_Name(tensor.dtype), " [",
                       absl::StrJoin(tensor.shape, ", "), "]"));
    }
  }
  for (size_t i = 0; i < slots_.size(); ++i) {
    const HostTensor& tensor = tensors.at(prefix + slots_[i].name);
    // libtorch wants a mutable pointer and only reads through it.
    void* data = const_cast<char*>(tensor.data.data());
    View(i).copy_(at::from_blob(data, slots_[i].shape, at::kFloat));
  }
  return absl::OkStatus();
}

void ParameterBuffer::Save(const std::string& prefix,
                           TensorMap& tensors) const {
  for (size_t i = 0; i < slots_.size(); ++i) {
    HostTensor tensor = HostTensor::Zeros(slots_[i].shape);
    at::from_blob(tensor.data.data(), slots_[i].shape, at::kFloat)
        .copy_(View(i).detach());
    tensors.insert_or_assign(prefix + slots_[i].name, std::move(tensor));
  }
}

std::vector<int> AllParameters(const v1::PolicyGraph& graph) {
  std::vector<int> numbers(graph.parameters_size());
  std::iota(numbers.begin(), numbers.end(), 0);
  return numbers;
}

}  // namespace sinew::learner
