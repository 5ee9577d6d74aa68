#include <filesystem>
#include <map>
#include <string>
#include <utility>

#include "absl/cleanup/cleanup.h"
#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/strip.h"
#include "common/digest.h"
#include "common/files.h"
#include "common/policy/onnx/onnx_writer.h"
#include "common/replace_directory.h"
#include "common/status_macros.h"
#include "deploy/bundle/bundle.h"
#include "deploy/bundle/manifest.h"
#include "deploy/bundle/replaceable.h"
#include "google/protobuf/text_format.h"

namespace sinew::bundle {
namespace {

using Files = std::map<std::string, std::string>;

// Graph names become file names.
absl::Status CheckGraphName(const std::string& name) {
  if (IsBundlePath(name) && !absl::StrContains(name, '/')) {
    return absl::OkStatus();
  }
  return absl::InvalidArgumentError(absl::StrCat(
      "graphs: expected a name that a file may have, found \"", name, "\""));
}

// All files but the manifest.
absl::StatusOr<Files> MakeFiles(const BundleContent& content) {
  Files files;
  for (const auto& [path, bytes] : content.character_files) {
    const std::string name = absl::StrCat(kCharacterFolder, "/", path);
    if (!IsBundlePath(name)) {
      return absl::InvalidArgumentError(
          absl::StrCat("character_files: expected a path inside the bundle, "
                       "found \"",
                       path, "\""));
    }
    files[name] = bytes;
  }
  if (!google::protobuf::TextFormat::PrintToString(content.graph,
                                                   &files[kGraphFile])) {
    return absl::InternalError(absl::StrCat(kGraphFile, ": not printable"));
  }
  const std::string weights = SerializeSafetensors(content.weights);
  SINEW_ASSIGN_OR_RETURN(const auto locations,
                         LocateSafetensors(weights, kWeightsFile));
  for (const v1::Graph& graph : content.graph.graphs()) {
    SINEW_RETURN_IF_ERROR(CheckGraphName(graph.name()));
    SINEW_ASSIGN_OR_RETURN(files[OnnxFile(graph.name())],
                           policy::WriteOnnx(content.graph, graph.name(),
                                             locations, kWeightsFile));
  }
  files[kWeightsFile] = weights;
  return files;
}

absl::StatusOr<std::string> MakeManifest(const BundleContent& content,
                                         const Files& files) {
  v1::BundleManifest manifest = content.manifest;
  manifest.set_format_version(kBundleFormatVersion);
  manifest.clear_graphs();
  for (const v1::Graph& graph : content.graph.graphs()) {
    manifest.add_graphs(graph.name());
  }
  manifest.clear_files();
  for (const auto& [name, bytes] : files) {
    (*manifest.mutable_files())[name] = Sha256Hex(bytes);
  }
  return PrintManifest(std::move(manifest));
}

absl::Status WriteAll(const Files& files, const std::string& manifest,
                      const std::string& folder) {
  SINEW_RETURN_IF_ERROR(MakeDirectories(folder));
  for (const auto& [name, bytes] : files) {
    const std::string path = JoinPath(folder, name);
    SINEW_RETURN_IF_ERROR(
        MakeDirectories(std::filesystem::path(path).parent_path().string()));
    SINEW_RETURN_IF_ERROR(WriteFileAtomically(path, bytes));
  }
  return WriteFileAtomically(JoinPath(folder, kManifestFile), manifest);
}

}  // namespace

absl::Status WriteBundle(const BundleContent& content,
                         const std::string& directory) {
  SINEW_ASSIGN_OR_RETURN(const Files files, MakeFiles(content));
  SINEW_ASSIGN_OR_RETURN(const std::string manifest,
                         MakeManifest(content, files));
  const std::string target(absl::StripSuffix(directory, "/"));
  const std::string aside = absl::StrCat(target, ".part");
  SINEW_RETURN_IF_ERROR(CheckReplaceable(target));
  SINEW_RETURN_IF_ERROR(RemoveRecursively(aside));
  const absl::Cleanup clean = [&aside] {
    RemoveRecursively(aside).IgnoreError();
  };
  SINEW_RETURN_IF_ERROR(WriteAll(files, manifest, aside));
  // Nobody is to find out later what could be found out now.
  SINEW_RETURN_IF_ERROR(ReadBundle(aside).status());
  return ReplaceDirectory(aside, target);
}

}  // namespace sinew::bundle
