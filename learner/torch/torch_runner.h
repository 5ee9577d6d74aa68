#ifndef SINEW_LEARNER_TORCH_TORCH_RUNNER_H_
#define SINEW_LEARNER_TORCH_TORCH_RUNNER_H_

#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "common/policy/safetensors.h"
#include "proto/sinew/v1/graph.pb.h"

namespace sinew::learner {

// Runs one graph through libtorch on host numbers: what parity checks and
// tests need, without libtorch's headers.
//
// Thread-safety: const methods from any thread. Ownership: copies graph and
// weights. Blocking: computes on the calling thread, as UseOneThread says.
// Errors: INVALID_ARGUMENT names what does not fit; INTERNAL carries libtorch's
// message.
class TorchRunner {
 public:
  struct Options {
    bool bfloat16 = false;       // products in bfloat16, emulated if need be
    std::string device = "cpu";  // or "cuda"
  };
  // Rows [batch, width], row-major, by input or tap name.
  using Rows = std::map<std::string, std::vector<float>>;

  static absl::StatusOr<std::unique_ptr<TorchRunner>> Create(
      const v1::PolicyGraph& graph, absl::string_view graph_name,
      const TensorMap& weights, const Options& options);
  virtual ~TorchRunner() = default;

  // Every tap of `batch` rows. Inputs that are not given are zero.
  virtual absl::StatusOr<Rows> Run(int64_t batch, const Rows& inputs) const = 0;

  // Gradient of sum(tap * cotangent) for every parameter that is not frozen
  // and that influences the tap, by parameter name; cotangent is
  // [batch, width of the tap].
  virtual absl::StatusOr<TensorMap> Gradient(
      int64_t batch, const Rows& inputs, const std::string& tap,
      const std::vector<float>& cotangent) const = 0;
};

}  // namespace sinew::learner

#endif  // SINEW_LEARNER_TORCH_TORCH_RUNNER_H_
