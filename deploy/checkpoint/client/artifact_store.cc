#include "deploy/checkpoint/client/artifact_store.h"

#include <cstdint>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "common/status_macros.h"
#include "deploy/checkpoint/client/validate_artifact.h"

namespace sinew::checkpoint {

absl::Status PutFiles(ArtifactStore& store, v1::Artifact record,
                      const ArtifactFiles& files) {
  std::vector<std::string> put;
  record.clear_files();
  absl::Status status;
  for (const auto& [path, blob] : files) {
    absl::StatusOr<std::string> sha256 = store.PutBlob(blob);
    if (!sha256.ok()) {
      status = sha256.status();
      break;
    }
    v1::Artifact::File& file = *record.add_files();
    file.set_path(path);
    file.set_sha256(*sha256);
    file.set_size(static_cast<int64_t>(blob->size()));
    put.push_back(*std::move(sha256));
  }
  if (status.ok()) status = store.PutArtifact(record);
  if (status.ok()) return status;
  // Bytes that nobody will name would only fill the disk; the error that the
  // caller has to know is the first one.
  store.DropBlobs(put).IgnoreError();
  return absl::Status(status.code(), absl::StrCat("artifact ", record.id(),
                                                  ": ", status.message()));
}

absl::StatusOr<ArtifactFiles> GetFiles(ArtifactStore& store,
                                       const std::string& name) {
  SINEW_ASSIGN_OR_RETURN(const v1::Artifact artifact, store.GetArtifact(name));
  // A store elsewhere may be of any build, or another's: its paths are about to
  // be names of files here.
  if (const absl::Status valid = ValidateArtifact(artifact); !valid.ok()) {
    return absl::DataLossError(valid.message());
  }
  ArtifactFiles files;
  for (const v1::Artifact::File& file : artifact.files()) {
    const std::string what =
        absl::StrCat("artifact ", artifact.id(), ", file ", file.path(), ": ");
    absl::StatusOr<Blob> blob = store.GetBlob(file.sha256());
    if (!blob.ok()) {
      return absl::Status(blob.status().code(),
                          absl::StrCat(what, blob.status().message()));
    }
    if (static_cast<int64_t>((*blob)->size()) != file.size()) {
      return absl::DataLossError(absl::StrCat(
          what, "expected ", file.size(), " bytes, found ", (*blob)->size()));
    }
    files[file.path()] = *std::move(blob);
  }
  return files;
}

}  // namespace sinew::checkpoint
