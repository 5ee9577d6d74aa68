#ifndef SINEW_TOOLS_PARITY_ONNX_RUNTIME_H_
#define SINEW_TOOLS_PARITY_ONNX_RUNTIME_H_

#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/time/time.h"
#include "common/policy/safetensors.h"

namespace sinew::tools {

// Where the Python half lies.
struct OnnxRuntimeOptions {
  // Python 3.11, for which the packages were built; looked up in PATH unless
  // it has a slash.
  std::string python = "python3.11";
  // tools/parity/onnx_check.py.
  std::string script;
  // Folder of unpacked packages (@onnx_python).
  std::string packages;
  // Existing folder for the exchanged files, which stay there.
  std::string scratch;
  // How long all models may take together.
  absl::Duration timeout = absl::Minutes(2);
};

// A model file with its inputs by name, [batch, width] float32.
struct OnnxJob {
  std::string model;
  TensorMap inputs;
};

// Checks each model (onnx.checker) and runs it (onnxruntime, CPU, one thread)
// in one child process. Returns each model's outputs by name, [batch, width]
// float32, in the order of the jobs.
//
// INTERNAL: the child failed; the message ends with what it said, which names
// the model and the cause. NOT_FOUND: no such Python. DEADLINE_EXCEEDED: the
// child was killed.
//
// Thread-safety: calls with different scratch folders. Blocking: about two
// seconds to start, at most `timeout`.
absl::StatusOr<std::vector<TensorMap>> RunOnnx(
    const OnnxRuntimeOptions& options, const std::vector<OnnxJob>& jobs);

}  // namespace sinew::tools

#endif  // SINEW_TOOLS_PARITY_ONNX_RUNTIME_H_
