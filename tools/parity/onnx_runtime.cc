#include "tools/parity/onnx_runtime.h"

#include <memory>
#include <utility>

#include "absl/status/status.h"
#include "absl/strings/ascii.h"
#include "absl/strings/str_cat.h"
#include "common/files.h"
#include "common/status_macros.h"
#include "common/subprocess.h"

namespace sinew::tools {
namespace {

std::string InputsPath(const OnnxRuntimeOptions& options, size_t job) {
  return JoinPath(options.scratch, absl::StrCat("inputs", job, ".safetensors"));
}

std::string OutputsPath(const OnnxRuntimeOptions& options, size_t job) {
  return JoinPath(options.scratch,
                  absl::StrCat("outputs", job, ".safetensors"));
}

// What the child said, for a message.
std::string Said(const std::string& log) {
  const absl::StatusOr<std::string> text = ReadFile(log, /*max_bytes=*/1 << 16);
  if (!text.ok()) return std::string(text.status().message());
  return std::string(absl::StripAsciiWhitespace(*text));
}

absl::Status RunChild(const OnnxRuntimeOptions& options,
                      std::vector<std::string> argv) {
  const std::string log = JoinPath(options.scratch, "onnx_check.log");
  SINEW_RETURN_IF_ERROR(WriteFileAtomically(log, ""));
  // Isolated: neither the user's packages nor PYTHON variables matter.
  SINEW_ASSIGN_OR_RETURN(
      const std::unique_ptr<Subprocess> child,
      Subprocess::Start({.argv = std::move(argv), .output_file = log}));
  SINEW_ASSIGN_OR_RETURN(const ExitStatus status, child->Wait(options.timeout));
  if (status.ok()) return absl::OkStatus();
  return absl::InternalError(
      absl::StrCat("onnx_check.py: ", status.ToString(), ": ", Said(log)));
}

}  // namespace

absl::StatusOr<std::vector<TensorMap>> RunOnnx(
    const OnnxRuntimeOptions& options, const std::vector<OnnxJob>& jobs) {
  std::vector<std::string> argv = {options.python, "-I",
                                   "-B",           options.script,
                                   "--packages",   options.packages};
  for (size_t i = 0; i < jobs.size(); ++i) {
    SINEW_RETURN_IF_ERROR(WriteFileAtomically(
        InputsPath(options, i), SerializeSafetensors(jobs[i].inputs)));
    argv.push_back(jobs[i].model);
    argv.push_back(InputsPath(options, i));
    argv.push_back(OutputsPath(options, i));
  }
  std::vector<TensorMap> results;
  if (jobs.empty()) return results;
  SINEW_RETURN_IF_ERROR(RunChild(options, std::move(argv)));
  for (size_t i = 0; i < jobs.size(); ++i) {
    const std::string path = OutputsPath(options, i);
    SINEW_ASSIGN_OR_RETURN(const std::string bytes, ReadFile(path));
    SINEW_ASSIGN_OR_RETURN(TensorMap outputs, ParseSafetensors(bytes, path));
    results.push_back(std::move(outputs));
  }
  return results;
}

}  // namespace sinew::tools
