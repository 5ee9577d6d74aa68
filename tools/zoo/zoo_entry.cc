#include "tools/zoo/zoo_entry.h"

#include <filesystem>
#include <initializer_list>
#include <nlohmann/json.hpp>
#include <string>
#include <system_error>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_replace.h"
#include "common/clock.h"
#include "common/config/recipe.h"
#include "common/digest.h"
#include "common/files.h"
#include "common/status_macros.h"
#include "deploy/bundle/bundle.h"
#include "tools/training/compact_state.h"
#include "tools/zoo/card_chapters.h"

namespace sinew::zoo {
namespace {

// "a.b" of "/a/b".
std::string FieldOf(const char* pointer) {
  return absl::StrReplaceAll(pointer + 1, {{"/", "."}});
}

using Pointer = nlohmann::json::json_pointer;

// A file of figures of this bundle: what `digest_at` points to is its digest,
// and what `paths_at` point to means something elsewhere.
absl::Status CheckFigures(const std::string& file, const std::string& digest,
                          const char* digest_at,
                          std::initializer_list<const char*> paths_at) {
  SINEW_ASSIGN_OR_RETURN(const std::string text, ReadFile(file));
  const nlohmann::json figures =
      nlohmann::json::parse(text, nullptr, /*allow_exceptions=*/false);
  const Pointer of(digest_at);
  if (!figures.is_object() || !figures.contains(of) ||
      figures[of] != nlohmann::json(digest)) {
    return absl::FailedPreconditionError(
        absl::StrCat(file, ": ", FieldOf(digest_at), ": expected ", digest,
                     ", found none or another"));
  }
  for (const char* path_at : paths_at) {
    const Pointer at(path_at);
    if (!figures.contains(at) || !figures[at].is_string()) continue;
    const auto path = figures[at].get<std::string>();
    if (!path.starts_with('/')) continue;
    return absl::FailedPreconditionError(absl::StrCat(
        file, ": ", FieldOf(path_at),
        ": expected a path relative to the project, found ", path));
  }
  return absl::OkStatus();
}

absl::Status CheckEvaluation(const std::string& file,
                             const std::string& digest) {
  return CheckFigures(file, digest, "/bundle/manifest_sha256",
                      {"/bundle/path", "/library/path"});
}

absl::Status CheckChapters(const std::string& file, const std::string& card,
                           bool has_prior) {
  for (const char* chapter : kChapters) {
    if (absl::StrContains(card, absl::StrCat("\n", chapter, "\n"))) continue;
    return absl::FailedPreconditionError(
        absl::StrCat(file, ": expected a chapter \"", chapter,
                     "\", found none (sinew card)"));
  }
  if (!absl::StrContains(card, "| zero action")) {
    return absl::FailedPreconditionError(absl::StrCat(
        file,
        ": expected figures beside the zero action's, found none (sinew "
        "card --eval)"));
  }
  if (has_prior && !absl::StrContains(card, absl::StrCat("\n", kPriorAlone))) {
    return absl::FailedPreconditionError(absl::StrCat(
        file,
        ": expected what its prior does alone, found none (sinew card "
        "--samples)"));
  }
  return absl::OkStatus();
}

// What training goes on from is of the recipe beside it, the file as its run
// wrote it.
absl::Status CheckState(const std::string& folder, const std::string& recipe) {
  SINEW_ASSIGN_OR_RETURN(const tools::CompactState state,
                         tools::ReadCompactState(folder, SystemClock()));
  const std::string expected = Sha256Hex(recipe);
  const auto found = state.assets.find("recipe");
  if (found != state.assets.end() && found->second == expected) {
    return absl::OkStatus();
  }
  return absl::FailedPreconditionError(absl::StrCat(
      folder, ": expected a state of the recipe beside it, ", expected,
      ", found ", found == state.assets.end() ? "none" : found->second));
}

// Files beside bundle and card.
absl::Status CheckFiles(const std::string& folder,
                        const v1::BundleManifest& manifest) {
  const std::string& digest = manifest.manifest_sha256();
  SINEW_RETURN_IF_ERROR(CheckEvaluation(JoinPath(folder, "eval.json"), digest));
  const std::string fallen = JoinPath(folder, "fallen.json");
  if (FileExists(fallen)) {
    SINEW_RETURN_IF_ERROR(CheckEvaluation(fallen, digest));
  }
  if (manifest.latent_width() > 0) {
    SINEW_RETURN_IF_ERROR(CheckFigures(JoinPath(folder, "samples.json"), digest,
                                       "/manifest_sha256",
                                       {"/bundle", "/library/motions"}));
  }
  const std::string recipe = JoinPath(folder, "recipe.textproto");
  SINEW_ASSIGN_OR_RETURN(const std::string text, ReadFile(recipe));
  SINEW_ASSIGN_OR_RETURN(const v1::Recipe parsed, ParseRecipe(text, recipe));
  if (parsed.name() != manifest.provenance().recipe()) {
    return absl::FailedPreconditionError(absl::StrCat(
        recipe, ": name: expected the bundle's recipe \"",
        manifest.provenance().recipe(), "\", found \"", parsed.name(), "\""));
  }
  const std::string state = JoinPath(folder, "state");
  return FileExists(state) ? CheckState(state, text) : absl::OkStatus();
}

}  // namespace

absl::StatusOr<int64_t> FolderBytes(const std::string& folder) {
  namespace fs = std::filesystem;
  std::error_code error;
  int64_t bytes = 0;
  fs::recursive_directory_iterator it(folder, error);
  for (; !error && it != fs::recursive_directory_iterator();
       it.increment(error)) {
    if (!it->is_regular_file(error) || error) continue;
    bytes += static_cast<int64_t>(it->file_size(error));
  }
  if (!error) return bytes;
  return absl::NotFoundError(
      absl::StrCat(folder, ": expected a folder: ", error.message()));
}

absl::StatusOr<int64_t> CheckBundleBytes(const std::string& bundle) {
  SINEW_ASSIGN_OR_RETURN(const int64_t bytes, FolderBytes(bundle));
  if (bytes <= kMostBundleBytes) return bytes;
  return absl::FailedPreconditionError(
      absl::StrCat(bundle, ": expected a bundle of at most ", kMostBundleBytes,
                   " bytes, found ", bytes));
}

absl::Status CheckZooEntry(const std::string& folder) {
  const std::string directory = JoinPath(folder, "bundle");
  SINEW_ASSIGN_OR_RETURN(const bundle::Bundle bundle,
                         bundle::ReadBundle(directory));
  SINEW_RETURN_IF_ERROR(CheckBundleBytes(directory).status());
  const std::string file = JoinPath(folder, "CARD.md");
  SINEW_ASSIGN_OR_RETURN(const std::string card, ReadFile(file));
  const std::string& digest = bundle.manifest.manifest_sha256();
  if (digest.empty() || !absl::StrContains(card, digest)) {
    return absl::FailedPreconditionError(
        absl::StrCat(file, ": expected the digest of the bundle's manifest, ",
                     digest, ", found none or another"));
  }
  SINEW_RETURN_IF_ERROR(
      CheckChapters(file, card, bundle.manifest.latent_width() > 0));
  SINEW_RETURN_IF_ERROR(CheckFiles(folder, bundle.manifest));
  const auto& licences = bundle.manifest.provenance().data_licences();
  if (licences.empty()) {
    return absl::FailedPreconditionError(absl::StrCat(
        directory, ": provenance.data_licences: expected some, found none"));
  }
  for (const std::string& licence : licences) {
    if (licence == bundle::kUnknown) {
      return absl::FailedPreconditionError(absl::StrCat(
          directory,
          ": provenance.data_licences: expected the licence of every clip, "
          "found one that is unknown (sinew motion import --licence)"));
    }
    if (!absl::StrContains(card, licence)) {
      return absl::FailedPreconditionError(absl::StrCat(
          file, ": expected the licence \"", licence, "\", found none"));
    }
  }
  return absl::OkStatus();
}

}  // namespace sinew::zoo
