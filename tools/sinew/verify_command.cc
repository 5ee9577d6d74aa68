#include "tools/sinew/verify_command.h"

#include <cstdlib>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_join.h"
#include "common/files.h"
#include "common/status_macros.h"
#include "common/temporary_folder.h"
#include "deploy/bundle/bundle.h"
#include "deploy/bundle/latent_graphs.h"
#include "tools/parity/bundle_parity.h"
#include "tools/parity/latent_parts.h"
#include "tools/parity/onnx_runtime.h"

namespace sinew::tools {
namespace {

struct VerifyOptions {
  std::string bundle;
  bool skip_onnx = false;
};

// Folders that hold "sinew" and the other repositories.
std::vector<std::string> RunfilesFolders() {
  std::vector<std::string> folders;
  for (const char* name : {"RUNFILES_DIR", "TEST_SRCDIR"}) {
    if (const char* folder = std::getenv(name)) folders.push_back(folder);
  }
  std::error_code error;
  const auto binary = std::filesystem::read_symlink("/proc/self/exe", error);
  if (!error) folders.push_back(binary.string() + ".runfiles");
  return folders;
}

absl::StatusOr<OnnxRuntimeOptions> FindOnnx() {
  std::vector<std::string> tried;
  for (const std::string& folder : RunfilesFolders()) {
    OnnxRuntimeOptions options;
    options.script = JoinPath(folder, "sinew/tools/parity/onnx_check.py");
    options.packages = JoinPath(folder, "onnx_python");
    if (FileExists(options.script) &&
        FileExists(JoinPath(options.packages, "onnxruntime"))) {
      return options;
    }
    tried.push_back(options.script);
    tried.push_back(options.packages);
  }
  return absl::FailedPreconditionError(
      absl::StrCat("onnxruntime is not here (--skip-onnx leaves it out): "
                   "looked for ",
                   absl::StrJoin(tried, ", ")));
}

void PrintBundle(const bundle::Bundle& bundle) {
  const v1::BundleManifest& manifest = bundle.manifest;
  absl::PrintF("%s: %s, %d joints, %d observations, %.10g Hz, %d files whole\n",
               bundle.directory, manifest.character(), manifest.joints_size(),
               manifest.observation_width(), manifest.control_hz(),
               manifest.files_size());
}

void PrintParity(const std::vector<ParityRow>& rows) {
  absl::PrintF("%-10s %-16s %14s %14s   (largest difference, at most %.0e)\n",
               "graph", "tap", "libtorch", "onnxruntime", kParityTolerance);
  for (const ParityRow& row : rows) {
    absl::PrintF("%-10s %-16s %14.2e %14s\n", row.graph, row.tap, row.torch,
                 row.onnx ? absl::StrFormat("%.2e", *row.onnx) : "skipped");
  }
}

absl::Status RunVerify(const VerifyOptions& options,
                       const StopToken& /*stop*/) {
  SINEW_ASSIGN_OR_RETURN(const bundle::Bundle bundle,
                         bundle::ReadBundle(options.bundle));
  PrintBundle(bundle);
  ParityOptions parity;
  std::unique_ptr<TemporaryFolder> scratch;
  if (!options.skip_onnx) {
    SINEW_ASSIGN_OR_RETURN(parity.onnx, FindOnnx());
    SINEW_ASSIGN_OR_RETURN(scratch, TemporaryFolder::Create());
    parity.onnx->scratch = scratch->path();
  }
  SINEW_ASSIGN_OR_RETURN(const std::vector<ParityRow> rows,
                         CompareBackEnds(bundle, parity));
  PrintParity(rows);
  SINEW_RETURN_IF_ERROR(CheckParity(rows));
  if (!bundle::HasLatent(bundle)) return absl::OkStatus();
  SINEW_ASSIGN_OR_RETURN(const LatentParts parts,
                         CompareLatentParts(bundle, parity.rows, parity.seed));
  absl::PrintF("policy and sample from encoder, prior, decoder: %.2e, %.2e\n",
               parts.policy, parts.sample);
  return CheckLatentParts(parts);
}

}  // namespace

void AddVerifyCommand(CLI::App& app, Action& action) {
  auto options = std::make_shared<VerifyOptions>();
  auto* command = AddSubcommand<VerifyOptions>(
      app, "verify", "digests of a bundle and parity of its back ends", options,
      action, RunVerify);
  command->add_option("bundle", options->bundle, "folder")->required();
  command->add_flag("--skip-onnx", options->skip_onnx,
                    "compare without onnxruntime");
}

}  // namespace sinew::tools
