#include "tools/zoo/zoo_entry.h"

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <system_error>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "common/files.h"
#include "common/status_macros.h"
#include "deploy/bundle/bundle.h"

namespace sinew::zoo {
namespace {

// A figure's file, if it is there: of this bundle, with paths that mean
// something elsewhere.
absl::Status CheckFigures(const std::string& file, const std::string& digest) {
  const absl::StatusOr<std::string> text = ReadFile(file);
  if (absl::IsNotFound(text.status())) return absl::OkStatus();
  SINEW_RETURN_IF_ERROR(text.status());
  const nlohmann::json figures =
      nlohmann::json::parse(*text, nullptr, /*allow_exceptions=*/false);
  const nlohmann::json::json_pointer of("/bundle/manifest_sha256");
  if (!figures.is_object() || !figures.contains(of) ||
      figures[of] != nlohmann::json(digest)) {
    return absl::FailedPreconditionError(
        absl::StrCat(file, ": bundle.manifest_sha256: expected ", digest,
                     ", found none or another"));
  }
  for (const char* subject : {"bundle", "library"}) {
    const nlohmann::json::json_pointer at(absl::StrCat("/", subject, "/path"));
    if (!figures.contains(at) || !figures[at].is_string()) continue;
    const auto path = figures[at].get<std::string>();
    if (!path.starts_with('/')) continue;
    return absl::FailedPreconditionError(absl::StrCat(
        file, ": ", subject,
        ".path: expected a path relative to the project, found ", path));
  }
  return absl::OkStatus();
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
  for (const char* figures : {"eval.json", "fallen.json"}) {
    SINEW_RETURN_IF_ERROR(CheckFigures(JoinPath(folder, figures), digest));
  }
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
