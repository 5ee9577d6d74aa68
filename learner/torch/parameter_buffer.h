#ifndef SINEW_LEARNER_TORCH_PARAMETER_BUFFER_H_
#define SINEW_LEARNER_TORCH_PARAMETER_BUFFER_H_

#include <ATen/core/Tensor.h>
#include <c10/core/Device.h>

#include <cstdint>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/types/span.h"
#include "common/policy/safetensors.h"
#include "proto/sinew/v1/graph.pb.h"

namespace sinew::learner {

// Some parameters of a PolicyGraph in one flat float32 tensor, so that sums,
// norms and optimiser steps over all of them are single operations. Every
// parameter begins at a multiple of 16 elements (64 bytes: matrix products
// then see the same alignment in every run); the gaps stay zero. Buffers of
// one layout (weights, gradients, moments) line up element by element.
//
// Thread-safety: reading from any thread; writing needs to be alone.
// Ownership: owns the flat tensor; views share it. Blocking: copies between
// devices. Errors: Load returns INVALID_ARGUMENT; else c10::Error (call it
// under CatchTorch).
class ParameterBuffer {
 public:
  // Zeros. `parameters` are numbers of `graph`'s parameters, rising.
  ParameterBuffer(const v1::PolicyGraph& graph, std::vector<int> parameters,
                  const at::Device& device);

  const at::Tensor& flat() const { return flat_; }
  // Numbers in the graph, in the order of the views.
  const std::vector<int>& parameters() const { return numbers_; }

  // Parameter number i of this buffer, in its own shape, sharing memory.
  at::Tensor View(size_t i) const;
  std::vector<at::Tensor> Views() const;
  // New autograd leaves that share memory: one set for each thread.
  std::vector<at::Tensor> Leaves() const;

  // Copies from or into tensors called prefix + parameter name. Load checks
  // all before it changes anything; a missing tensor is an error.
  absl::Status Load(const TensorMap& tensors, const std::string& prefix);
  void Save(const std::string& prefix, TensorMap& tensors) const;

 private:
  struct Slot {
    std::string name;
    std::vector<int64_t> shape;
    int64_t offset = 0;
    int64_t size = 0;
  };
  std::vector<int> numbers_;
  std::vector<Slot> slots_;
  at::Tensor flat_;
};

// Numbers of all parameters of a graph. Pure.
std::vector<int> AllParameters(const v1::PolicyGraph& graph);

}  // namespace sinew::learner

#endif  // SINEW_LEARNER_TORCH_PARAMETER_BUFFER_H_
