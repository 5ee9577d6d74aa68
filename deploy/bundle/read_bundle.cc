#include <map>
#include <set>
#include <string>
#include <utility>

#include "absl/strings/str_cat.h"
#include "common/config/recipe.h"
#include "common/config/text_proto.h"
#include "common/digest.h"
#include "common/files.h"
#include "common/status_macros.h"
#include "deploy/bundle/bundle.h"
#include "deploy/bundle/bundle_check.h"
#include "deploy/bundle/manifest.h"

namespace sinew::bundle {
namespace {

constexpr int64_t kMaxManifestBytes = int64_t{64} << 20;
constexpr int64_t kMaxFileBytes = int64_t{2} << 30;

// Content of a file once its digest holds.
absl::StatusOr<std::string> ReadVerified(const v1::BundleManifest& manifest,
                                         const std::string& directory,
                                         const std::string& name) {
  const std::string path = JoinPath(directory, name);
  const auto entry = manifest.files().find(name);
  if (entry == manifest.files().end()) {
    return absl::InvalidArgumentError(
        absl::StrCat(JoinPath(directory, kManifestFile), ": files: expected \"",
                     name, "\", found no such entry"));
  }
  SINEW_ASSIGN_OR_RETURN(std::string content, ReadFile(path, kMaxFileBytes));
  const std::string found = Sha256Hex(content);
  if (found == entry->second) return content;
  return absl::DataLossError(absl::StrCat(
      path, ": expected SHA-256 ", entry->second, ", found ", found, " (",
      content.size(), " bytes): truncated, altered, or of another bundle"));
}

using Files = std::map<std::string, std::string>;

// Content of every file that the manifest names; those that must be are.
absl::StatusOr<Files> ReadFiles(const v1::BundleManifest& manifest,
                                const std::string& directory) {
  std::set<std::string> names = {kGraphFile, kWeightsFile, OnnxFile("policy"),
                                 kCharacterFile};
  for (const std::string& graph : manifest.graphs()) {
    names.insert(OnnxFile(graph));
  }
  for (const auto& [name, digest] : manifest.files()) {
    if (!IsBundlePath(name)) {
      return absl::InvalidArgumentError(absl::StrCat(
          JoinPath(directory, kManifestFile),
          ": files: expected a path inside the bundle, found \"", name, "\""));
    }
    names.insert(name);
  }
  Files files;
  for (const std::string& name : names) {
    SINEW_ASSIGN_OR_RETURN(files[name],
                           ReadVerified(manifest, directory, name));
  }
  return files;
}

}  // namespace

absl::StatusOr<Bundle> ReadBundle(const std::string& directory) {
  const std::string manifest_file = JoinPath(directory, kManifestFile);
  if (!FileExists(manifest_file)) {
    return absl::NotFoundError(absl::StrCat(
        directory, ": expected a bundle, found no ", kManifestFile));
  }
  SINEW_ASSIGN_OR_RETURN(const std::string json,
                         ReadFile(manifest_file, kMaxManifestBytes));
  Bundle bundle;
  bundle.directory = directory;
  SINEW_ASSIGN_OR_RETURN(bundle.manifest, ParseManifest(json, manifest_file));
  SINEW_ASSIGN_OR_RETURN(const Files files,
                         ReadFiles(bundle.manifest, directory));
  SINEW_RETURN_IF_ERROR(ParseTextProto(
      files.at(kGraphFile), JoinPath(directory, kGraphFile), bundle.graph));
  SINEW_ASSIGN_OR_RETURN(bundle.weights,
                         ParseSafetensors(files.at(kWeightsFile),
                                          JoinPath(directory, kWeightsFile)));
  SINEW_ASSIGN_OR_RETURN(
      bundle.character,
      character::Character::Load(bundle.character_file(),
                                 TaskRecipe(bundle.manifest).physics()));
  SINEW_RETURN_IF_ERROR(CheckBundle(bundle));
  return bundle;
}

v1::Recipe TaskRecipe(const v1::BundleManifest& manifest) {
  v1::Recipe recipe;
  recipe.set_format_version(1);
  *recipe.mutable_physics() = manifest.physics();
  *recipe.mutable_task() = manifest.task();
  // Which clips training drew starts from says nothing of other uses.
  recipe.mutable_task()->mutable_start()->clear_only_clips();
  recipe.mutable_task()->mutable_start()->clear_other_clips_share();
  v1::Evaluation& evaluation = *recipe.mutable_evaluation();
  if (manifest.has_max_mean_body_distance()) {
    evaluation.set_max_mean_body_distance(manifest.max_mean_body_distance());
  }
  // Of training alone; there must be one where starts followed evaluations.
  evaluation.set_interval(1);
  return WithDefaults(std::move(recipe));
}

}  // namespace sinew::bundle
