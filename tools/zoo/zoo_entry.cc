#include "tools/zoo/zoo_entry.h"

#include <filesystem>
#include <system_error>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "common/files.h"
#include "common/status_macros.h"
#include "deploy/bundle/bundle.h"

namespace sinew::zoo {

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
